/* export.c: slipdisk export FILE --to FORMAT: see export.h and docs/export.md. */
#include "app/export/export.h"

#include <assert.h>
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "app/app.h"
#include "base/memory.h"
#include "base/text.h"
#include "io/store/file.h"

#define FORMAT_NAMES "h5md3d|lammps-dump|lammps-data|extxyz|vtk|csv"

static const struct format {
  const char *name, *ending;
  bool single; /* one frame: the last, where none is chosen */
  bool folder;
  export_writer *write;
} formats[] = {
    {"h5md3d", "h5md", false, false, export_h5md},     {"lammps-dump", "dump", false, false, export_dump},
    {"lammps-data", "data", true, false, export_data}, {"extxyz", "extxyz", false, false, export_xyz},
    {"vtk", "vtk", false, true, export_vtk},           {"csv", "tables", false, true, export_csv},
};
enum { FORMATS = sizeof formats / sizeof *formats };

typedef struct arguments {
  const char *name, *format, *output, *frames;
} arguments;

static const option_row rows[] = {
    {"to", 0, OPTION_CHOICE, offsetof(arguments, format), NULL, FORMAT_NAMES,
     "what it is written as; must be given"},
    {"output", 'o', OPTION_PATH, offsetof(arguments, output), NULL, "OUT",
     "file, or folder of vtk and csv; by default the name of FILE with the format's ending, in the current "
     "folder"},
    {"frames", 0, OPTION_TEXT, offsetof(arguments, frames), NULL, "RANGE",
     "a frame (5, -1 the last) or FIRST:END:STEP as slices in Python; by default all, of lammps-data the "
     "last"},
};
const command_line app_export_line = {
    .name = "export",
    .n = sizeof rows / sizeof *rows,
    .rows = rows,
    .operand = OPERAND_RESULT,
    .offset = offsetof(arguments, name),
    .operands = "FILE",
    .summary = "Writes frames for other programs: MDAnalysis, LAMMPS, OVITO, ParaView, tables",
    .more = "  h5md3d       H5MD in three dimensions: MDAnalysis\n"
            "  lammps-dump  text dump: LAMMPS, OVITO\n"
            "  lammps-data  one frame as the start of a run of LAMMPS\n"
            "  extxyz       extended XYZ: OVITO, ASE\n"
            "  vtk          folder with vtp files and pvd lists of disks, contacts, walls: ParaView, VTK\n"
            "  csv          folder with tables of disks, contacts, series\n",
    .examples = "slipdisk export deck.h5 --to csv                        # the folder deck.tables\n"
                "slipdisk export deck.h5 --to vtk --frames ::10          # every tenth frame, for ParaView\n"
                "slipdisk export deck.h5 --to lammps-data -o start.data  # the last frame\n"};

/* --- frames ---------------------------------------------------------------------------------------------- */

sd_status export_frame(const export_job *job, size_t k, frame_data *frame) {
  return frames_read(job->f, job->range.first + k * job->range.step, frame, job->messages);
}

size_t export_count(const export_job *job, const frame_data *frame) {
  size_t n = 0;
  for (size_t i = 0; i < job->m->n_disks; i++) n += export_has(job, frame, i);
  return n;
}

static void include(export_space *s, const double at[2], double radius) {
  for (int c = 0; c < 2; c++) {
    s->lower[c] = fmin(s->lower[c], at[c] - radius);
    s->upper[c] = fmax(s->upper[c], at[c] + radius);
  }
}

export_space export_space_of(const export_job *job, const frame_data *f) {
  const sd_model *m = job->m;
  export_space s = {
      {HUGE_VAL, HUGE_VAL, -0.5 * job->depth}, {-HUGE_VAL, -HUGE_VAL, 0.5 * job->depth}, f->offset};
  for (size_t i = 0; i < m->n_disks; i++)
    if (export_has(job, f, i)) include(&s, f->position[i], m->disks[i].radius);
  for (size_t w = 0; w < m->n_walls; w++) {
    const sd_wall *wall = &m->walls[w];
    if (wall->kind == SD_WALL_CIRCLE) include(&s, f->position[m->n_disks + w], wall->radius);
    for (size_t k = 0; wall->kind != SD_WALL_CIRCLE && k < wall->n_points; k++) {
      double at[2];
      configuration_wall_point(wall, f, m->n_disks + w, k, at);
      include(&s, at, 0.0);
    }
  }
  for (int c = 0; c < 2; c++) {
    if (m->periodic[c]) {
      s.lower[c] = m->lower[c];
      s.upper[c] = m->lower[c] + f->scale * f->stretch[c] * (m->upper[c] - m->lower[c]);
    }
    if (!(s.lower[c] < s.upper[c])) s.lower[c] = 0.0, s.upper[c] = 1.0; /* nothing is there */
  }
  return s;
}

/* --- types ----------------------------------------------------------------------------------------------- */

const char *export_material(const export_job *job, int material) {
  const char *name = job->m->materials[material].name;
  return name ? name : "";
}

const char *export_group(const export_job *job, int group) {
  return group >= 0 && (size_t)group < job->m->n_groups && job->m->groups[group] ? job->m->groups[group] : "";
}

char *export_type_text(const export_job *job, size_t type) {
  const export_type *t = &job->types[type];
  const char *material = export_material(job, t->material), *group = export_group(job, t->group);
  return format_text("%s%s%s%s%s", *material ? "material " : "", *material ? material : "disks",
                     *group ? ", group " : "", group, t->driven ? ", fixed or driven" : "");
}

static sd_status find_types(export_job *job) {
  const sd_model *m = job->m;
  if (!memory_row(&job->type_of, m->n_disks, sizeof *job->type_of))
    return sd_fail(job->messages, SD_ERROR_IO, "no memory to export");
  for (size_t i = 0; i < m->n_disks; i++) {
    const sd_disk *d = &m->disks[i];
    size_t k = 0;
    job->depth = fmax(job->depth, 2.0 * d->radius);
    while (k < job->n_types && (job->types[k].material != d->material || job->types[k].group != d->group ||
                                job->types[k].driven != d->driven))
      k++;
    job->type_of[i] = (uint32_t)k;
    if (k < job->n_types) continue;
    job->types = memory_grow(job->types, k + 1, sizeof *job->types);
    job->types[job->n_types++] = (export_type){d->material, d->group, d->driven};
  }
  if (!(job->depth > 0.0)) job->depth = 1.0;
  return SD_OK;
}

/* --- command --------------------------------------------------------------------------------------------- */

static int parse(int argc, char **argv, arguments *a, const struct format **format) {
  int mistake = options_parse(&app_export_line, argc, argv, a);
  if (mistake) return mistake;
  for (size_t k = 0; a->format && k < FORMATS; k++)
    if (strcmp(formats[k].name, a->format) == 0) *format = &formats[k];
  return *format ? 0 : app_misuse("export", "the format is not said; expected --to %s", FORMAT_NAMES);
}

static sd_status check_output(const export_job *job, const struct format *format) {
  if (format->folder || !file_is_folder(job->out)) return SD_OK;
  return sd_fail(job->messages, SD_ERROR_USER, "-o %s is a folder; expected the name of a file", job->out);
}

static sd_status check_single(const export_job *job, const char *format, const arguments *a) {
  if (job->range.n == 1) return SD_OK;
  return sd_fail(job->messages, SD_ERROR_USER,
                 "--frames %s chooses %zu frames; %s takes one, such as --frames %zu", a->frames,
                 job->range.n, format, job->range.first);
}

/* "r.extxyz" of ".../r.h5" and of ".../r.h5.parts/"; to be freed. */
static char *default_output(const char *name, const char *ending) {
  static const char parts[] = ".parts";
  size_t length = strlen(name), tail = sizeof parts - 1;
  while (length > 1 && name[length - 1] == '/') length--;
  if (length > tail && strncmp(name + length - tail, parts, tail) == 0) length -= tail;
  char *result = format_text("%.*s", (int)length, name), *out = app_default_name(result, ending);
  free(result);
  return out;
}

static void tell(const export_job *job) {
  char first[32] = "";
  if (job->range.n > 1)
    snprintf(first, sizeof first, "%zu frames", job->range.n);
  else
    snprintf(first, sizeof first, "frame %zu", job->range.first);
  app_line(stdout, "%s: %s of %s, %zu disks", job->out, first, job->source, job->m->n_disks);
}

static sd_status export(const arguments *a, const struct format *format, sd_messages *messages) {
  frames f = {0};
  bool alone;
  size_t count = 0;
  option_range syntax;
  char *named = a->output ? NULL : default_output(a->name, format->ending);
  export_job job = {.source = a->name, .out = a->output ? a->output : named, .f = &f, .messages = messages};
  sd_status status = options_range(a->frames, SIZE_MAX, a->name, &syntax, messages);
  if (status == SD_OK) status = stored_open(&f, a->name, &alone, messages);
  if (status == SD_OK) status = stored_count(&f, alone, &count, messages);
  const char *range = a->frames ? a->frames : format->single ? "-1" : NULL;
  if (status == SD_OK) status = options_range(range, count, a->name, &job.range, messages);
  if (status == SD_OK && format->single) status = check_single(&job, format->name, a);
  job.m = f.constants;
  if (status == SD_OK) status = check_output(&job, format);
  if (status == SD_OK) status = find_types(&job);
  if (status == SD_OK) status = format->write(&job);
  if (status == SD_OK) tell(&job);
  free(job.type_of);
  free(job.types);
  frames_close(&f);
  free(named);
  return status;
}

int app_export(int argc, char **argv) {
  arguments a = {0};
  const struct format *format = NULL;
  int mistake = parse(argc, argv, &a, &format);
  if (mistake) return mistake;
  assert(format);
  sd_messages *messages = sd_messages_new();
  sd_status status = export(&a, format, messages);
  fflush(stdout);
  sd_messages_print(messages, stderr);
  sd_messages_free(messages);
  return (int)status;
}
