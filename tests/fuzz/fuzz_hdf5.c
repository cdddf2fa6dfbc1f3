/* fuzz_hdf5.c: results, checkpoints and tables in HDF5, altered through the library.
 *
 * The library itself does not stand altered bytes (1.10.8 reads beyond its buffers and divides by zero), so the file is
 * always one that it would write: the input is a program that deletes, replaces and rewrites datasets, links and
 * attributes of a sound file. Altered bytes are met by the checksums; the mode `altered` of the soak tries those.
 * The sound files are named in SLIPDISK_FUZZ_FILES, with : between; the first byte chooses one, the second
 * what reads it.
 */
#include "fuzz.h"

#include <hdf5.h>

#include "io/results/checkpoint.h"
#include "io/results/frames.h"
#include "io/results/provenance.h"
#include "io/results/summary.h"
#include "io/store/h5_private.h"
#include "model/model.h"

enum { MOST_FILES = 8, MOST_PATHS = 600, MOST_OPERATIONS = 6 };

typedef struct seed {
  void *image;
  size_t size, n_paths;
  char *paths[MOST_PATHS]; /* of datasets and groups */
} seed;

static seed seeds[MOST_FILES];
static size_t n_seeds;

/* The rest of the input; zeros when it is used up. */
typedef struct input {
  const uint8_t *data;
  size_t n;
} input;

static unsigned byte(input *in) {
  if (in->n == 0) return 0;
  in->n--;
  return *in->data++;
}

static herr_t add_path(hid_t group, const char *name, const H5O_info_t *info, void *user) {
  seed *s = user;
  (void)group, (void)info;
  if (s->n_paths < MOST_PATHS && strcmp(name, ".") != 0 &&
      asprintf(&s->paths[s->n_paths], "/%s", name) > 0)
    s->n_paths++;
  return 0;
}

static hid_t open_image(const void *image, size_t size) {
  hid_t access = H5Pcreate(H5P_FILE_ACCESS);
  H5Pset_fapl_core(access, 1 << 20, false);
  H5Pset_file_image(access, (void *)(uintptr_t)image, size);
  hid_t file = H5Fopen("fuzz", H5F_ACC_RDWR, access);
  H5Pclose(access);
  return file;
}

int LLVMFuzzerInitialize(int *argc, char ***argv);
int LLVMFuzzerInitialize(int *argc, char ***argv) {
  (void)argc, (void)argv;
  char *names = strdup(getenv("SLIPDISK_FUZZ_FILES") ? getenv("SLIPDISK_FUZZ_FILES") : ""),
       *rest = NULL;
  H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
  for (char *name = strtok_r(names, ":", &rest); name && n_seeds < MOST_FILES;
       name = strtok_r(NULL, ":", &rest)) {
    seed *s = &seeds[n_seeds++];
    FILE *in = fopen(name, "rb");
    assert(in);
    s->image = malloc(1 << 24);
    s->size = fread(s->image, 1, 1 << 24, in);
    fclose(in);
    hid_t file = open_image(s->image, s->size);
    assert(file >= 0);
    H5Ovisit(file, H5_INDEX_NAME, H5_ITER_INC, add_path, s);
    H5Fclose(file);
  }
  free(names);
  assert(n_seeds > 0); /* SLIPDISK_FUZZ_FILES names no file */
  return 0;
}

static const char *some_path(const seed *s, input *in) {
  unsigned k = byte(in) << 8;
  k |= byte(in);
  return s->paths[k % s->n_paths];
}

static hsize_t some_extent(input *in) {
  static const hsize_t odd[] = {0,
                                1,
                                2,
                                3,
                                4,
                                5,
                                100,
                                5000,
                                5001,
                                1 << 20,
                                (hsize_t)1 << 31,
                                (hsize_t)1 << 32,
                                (hsize_t)1 << 40};
  return odd[byte(in) % (sizeof odd / sizeof *odd)];
}

static hid_t some_type(input *in) {
  hid_t types[] = {H5T_NATIVE_DOUBLE, H5T_NATIVE_INT64, H5T_NATIVE_INT32,  H5T_NATIVE_UINT32,
                   H5T_NATIVE_UINT8,  H5T_NATIVE_FLOAT, H5T_NATIVE_UINT64, H5T_IEEE_F32BE};
  return H5Tcopy(types[byte(in) % 8]);
}

/* Fills memory from the input, over and over. */
static void fill(input *in, void *data, size_t n) {
  for (size_t k = 0; k < n; k++) ((uint8_t *)data)[k] = in->n ? in->data[k % in->n] : 0;
}

/* Another dataset in its place: of any type and shape, whole, in chunks, outside or not written at all. */
static void replace(hid_t file, const char *path, input *in) {
  int rank = (int)(byte(in) % 6);
  hsize_t dims[6], total = 1, chunk[6];
  for (int k = 0; k < rank; k++) {
    total *= dims[k] = some_extent(in);
    chunk[k] = dims[k] < 4 ? dims[k] + (dims[k] == 0) : 4;
  }
  hid_t type = some_type(in),
        space = rank ? H5Screate_simple(rank, dims, NULL) : H5Screate(H5S_SCALAR);
  hid_t made = H5Pcreate(H5P_DATASET_CREATE);
  unsigned form = byte(in) % 5;
  if (form == 1 && rank) H5Pset_chunk(made, rank, chunk);
  if (form == 2 && rank) H5Pset_chunk(made, rank, dims), H5Pset_deflate(made, 6);
  if (form == 3) H5Pset_external(made, "/dev/zero", 0, H5F_UNLIMITED);
  H5Ldelete(file, path, H5P_DEFAULT);
  hid_t set = H5Dcreate2(file, path, type, space, H5P_DEFAULT, made, H5P_DEFAULT);
  if (set >= 0 && form != 3 && form != 4 && total < 6000) {
    void *data = calloc(total + 1, 16);
    fill(in, data, total * H5Tget_size(type));
    H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data);
    free(data);
  }
  if (set >= 0) H5Dclose(set);
  H5Pclose(made);
  H5Tclose(type);
  H5Sclose(space);
}

/* Some of its bytes. */
static void rewrite(hid_t file, const char *path, input *in) {
  hid_t set = H5Dopen2(file, path, H5P_DEFAULT);
  if (set < 0) return;
  hid_t type = H5Dget_type(set), space = H5Dget_space(set);
  size_t n = (size_t)H5Sget_simple_extent_npoints(space) * H5Tget_size(type), at = byte(in) << 8,
         length = byte(in) % 33;
  at |= byte(in);
  unsigned char *data =
      n > 0 && n < 1 << 20 && H5Tget_class(type) != H5T_STRING ? calloc(n, 1) : NULL;
  if (data && H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) >= 0) {
    at %= n;
    fill(in, data + at, length < n - at ? length : n - at);
    H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data);
  }
  free(data);
  H5Tclose(type);
  H5Sclose(space);
  H5Dclose(set);
}

static void put_text(hid_t file, const char *path, const char *attribute, input *in) {
  char text[80];
  size_t n = byte(in) % 79;
  fill(in, text, n);
  text[n] = 0;
  bool variable = byte(in) % 2;
  const char *pointer = text;
  hid_t type = H5Tcopy(H5T_C_S1), space = H5Screate(H5S_SCALAR);
  H5Tset_size(type, variable ? H5T_VARIABLE : n + 1);
  if (attribute) {
    H5Adelete_by_name(file, path, attribute, H5P_DEFAULT);
    hid_t attr = H5Acreate_by_name(file, path, attribute, type, space, H5P_DEFAULT, H5P_DEFAULT,
                                   H5P_DEFAULT);
    if (attr >= 0) H5Awrite(attr, type, variable ? (const void *)&pointer : text), H5Aclose(attr);
  } else {
    H5Ldelete(file, path, H5P_DEFAULT);
    hid_t set = H5Dcreate2(file, path, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    if (set >= 0)
      H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, variable ? (const void *)&pointer : text),
          H5Dclose(set);
  }
  H5Tclose(type);
  H5Sclose(space);
}

/* One of the object's attributes: another number, another text, or none. */
static void attribute(hid_t file, const char *path, input *in) {
  hid_t object = H5Oopen(file, path, H5P_DEFAULT);
  if (object < 0) return;
  int n = H5Aget_num_attrs(object);
  char name[80] = "";
  if (n > 0)
    H5Aget_name_by_idx(object, ".", H5_INDEX_NAME, H5_ITER_INC, byte(in) % (unsigned)n, name,
                       sizeof name, H5P_DEFAULT);
  H5Oclose(object);
  if (!*name) return;
  unsigned what = byte(in) % 4;
  if (what == 0) {
    put_text(file, path, name, in);
    return;
  }
  H5Adelete_by_name(file, path, name, H5P_DEFAULT);
  if (what == 1) return;
  static const int64_t odd[] = {
      0, 1, 2, 3, 255, -1, INT64_MIN, INT64_MAX, UINT32_MAX, INT64_C(1) << 40, 5000, 7, 8, 9, 10};
  hsize_t length = byte(in) % 3 + 1;
  int64_t value[3];
  for (int k = 0; k < 3; k++) value[k] = odd[byte(in) % (sizeof odd / sizeof *odd)];
  hid_t space = what == 2 ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &length, NULL);
  hid_t attr = H5Acreate_by_name(file, path, name, H5T_NATIVE_INT64, space, H5P_DEFAULT,
                                 H5P_DEFAULT, H5P_DEFAULT);
  if (attr >= 0) H5Awrite(attr, H5T_NATIVE_INT64, value), H5Aclose(attr);
  H5Sclose(space);
}

static void relink(hid_t file, const char *path, const char *other, input *in) {
  H5Ldelete(file, path, H5P_DEFAULT);
  switch (byte(in) % 5) {
    case 0: H5Lcreate_soft(other, file, path, H5P_DEFAULT, H5P_DEFAULT); break;
    case 1:
      H5Lcreate_external("/proc/self/fd/0", other, file, path, H5P_DEFAULT, H5P_DEFAULT);
      break;
    case 2: H5Lcreate_hard(file, other, file, path, H5P_DEFAULT, H5P_DEFAULT); break;
    case 3: H5Lcreate_hard(file, "/", file, path, H5P_DEFAULT, H5P_DEFAULT); break;
    default: break;
  }
}

static void alter(hid_t file, const seed *s, input *in) {
  for (int k = 0; k < MOST_OPERATIONS && in->n > 0; k++) {
    unsigned what = byte(in) % 6;
    const char *path = some_path(s, in);
    if (what == 0) replace(file, path, in);
    if (what == 1 || what == 2) rewrite(file, path, in);
    if (what == 3) attribute(file, path, in);
    if (what == 4) put_text(file, path, NULL, in);
    if (what == 5) relink(file, path, some_path(s, in), in);
  }
}

static void look(void *user, const char *path, sd_type type, bool text, int rank,
                 const size_t *dims) {
  (void)type, (void)text, (void)rank, (void)dims;
  *(size_t *)user += strlen(path);
}

static void read_result(const char *path) {
  sd_messages *messages = sd_messages_new();
  h5_file *file;
  if (h5_open(path, &file, messages) == SD_OK) {
    summary found;
    provenance origin;
    size_t total = 0;
    if (summary_read(&found, file, messages) == SD_OK)
      summary_disks_read_all(&found.packing, file, messages);
    provenance_read(&origin, file);
    if (origin.deck_full) {
      sd_model *m = NULL;
      sd_state *state = NULL;
      sd_deck_load_text(origin.deck_full, "fuzz.cfg", 0, NULL, &m, messages);
      if (m && checkpoint_get_state(file, m, &state, messages) == SD_OK) sd_state_free(state);
      sd_model_free(m);
    }
    h5_visit(file, look, &total, messages);
    summary_free(&found);
    provenance_free(&origin);
    h5_close(file, NULL);
  }
  sd_messages_free(messages);
}

static void read_frames(const char *path) {
  sd_messages *messages = sd_messages_new();
  frames f;
  if (frames_open(&f, path, 1, &path, sd_deck_load_text, messages) == SD_OK)
    for (size_t k = 0; k <= f.n && k < 3; k++) {
      frame_data data;
      size_t nearest;
      frames_read(&f, k < 2 ? k : f.n, &data, messages);
      frame_data_free(&data);
      frames_nearest(&f, 0.01, &nearest, messages);
    }
  frames_close(&f);
  sd_messages_free(messages);
}

static void read_table(const char *path, size_t k) {
  static const char *const asked[] = {
      "contacts = true;",
      "dataset = \"/compound\"; mass = 1;",
      "dataset = \"/matrix\"; mass = 1;",
      "dataset = \"/columns\"; mass = 1;",
      "mass = 1; dataset = \"/particles/disks\"; columns = (\"x\", \"y\", \"omega\", \"radius\");",
  };
  char text[600];
  snprintf(text, sizeof text,
           "dt = 1e-4; steps = 1; max_overlap = 1; materials = ( { name = \"a\"; k_n = 1; } );\n"
           "disk_files = ( { file = \"%s\"; format = \"hdf5\"; %s } );",
           path, asked[k % (sizeof asked / sizeof *asked)]);
  sd_model_free(fuzz_load(text, 0, NULL));
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  input in = {data, size};
  const seed *s = &seeds[byte(&in) % n_seeds];
  unsigned reader = byte(&in);
  H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
  hid_t file = open_image(s->image, s->size);
  assert(file >= 0);
  alter(file, s, &in);
  H5Fflush(file, H5F_SCOPE_GLOBAL);
  ssize_t n = H5Fget_file_image(file, NULL, 0);
  void *image = n > 0 ? malloc((size_t)n) : NULL;
  bool taken = image && H5Fget_file_image(file, image, (size_t)n) == n;
  H5Fclose(file);
  if (taken) {
    const char *path = fuzz_file(image, (size_t)n);
    if (reader % 4 == 0) read_result(path);
    if (reader % 4 == 1) read_frames(path);
    if (reader % 4 >= 2) read_table(path, reader / 4);
  }
  free(image);
  return 0;
}
