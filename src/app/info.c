/* info.c: `slipdisk info FILE` prints the results of a run. It reads only attributes and small
 * datasets, so its time does not depend on the size of the file; but means of very many disks,
 * which a checkpoint does not store, are computed here. */
#include <inttypes.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "app/app.h"
#include "app/json.h"
#include "base/limits.h"
#include "base/memory.h"
#include "base/text.h"
#include "io/results/checkpoint.h"
#include "io/store/file.h"
#include "io/store/folder.h"
#include "measure/measurement.h"
#include "model/model.h"
#include "slipdisk/deck.h"

/* All data that info prints about one run. */
typedef struct facts {
  char *path; /* Path of the file that was read */
  bool finished;
  int64_t parts; /* Number of part files of an unfinished run; -1: the run is finished */
  int64_t clumps;
  uint64_t bytes;
  provenance origin;
  summary found;
  json_t *datasets; /* JSON array of the datasets in the file, as objects {path, type, shape} */
} facts;

static void facts_free(facts *f) {
  free(f->path);
  provenance_free(&f->origin);
  summary_free(&f->found);
  json_decref(f->datasets);
  *f = (facts){0};
}

static void add_dataset(void *user, const char *path, sd_type type, bool text, int rank,
                        const size_t *dims) {
  static const char *const names[] = {
      [SD_F64] = "float64", [SD_I64] = "int64", [SD_I32] = "int32", [SD_U32] = "uint32"};
  json_t *shape = json_array();
  for (int k = 0; k < rank && k < H5_MAX_RANK; k++)
    json_array_append_new(shape, json_integer((json_int_t)dims[k]));
  json_array_append_new(user, json_pack("{s:s, s:s, s:o}", "path", path, "type",
                                        text ? "text" : names[type], "shape", shape));
}

/* Selects which means of disks are read. MEANS_AS_WRITTEN: totals and fastest disks as stored in
 * the file, enough for the output as text; MEANS_ALL: means of every disk, for JSON. */
typedef enum wanted_means { MEANS_AS_WRITTEN, MEANS_ALL } wanted_means;

/* Computes the means of every disk if the file does not store them. If that fails, because files
 * named in the deck are missing, warns and drops the means; everything else stays. */
static void complete_means(facts *f, const h5_file *file, sd_messages *messages) {
  sd_messages *own = sd_messages_new();
  if (checkpoint_complete(file, f->path, NULL, sd_deck_load_text, &f->found.packing, own) !=
      SD_OK) {
    messages_append(messages, SD_OK, own);
    sd_warn(messages, "%s: the means of every disk cannot be told", f->path);
    summary_disks_free(&f->found.packing);
  }
  sd_messages_free(own);
}

/* Reads the finished result if there is one and the user did not name a folder of parts or a
 * checkpoint; else reads a checkpoint. */
static sd_status read_facts(facts *f, const place *p, bool named_parts, wanted_means means,
                            sd_messages *messages) {
  h5_file *file = NULL;
  f->finished = file_exists(p->result) && !named_parts && !p->checkpoint;
  f->datasets = json_array();
  sd_status status;
  if (f->finished) {
    f->path = memory_text(p->result);
    status = h5_open(p->result, &file, messages);
  } else {
    status = place_open_checkpoint(p, &file, &f->path, messages);
  }
  if (status == SD_OK) status = checkpoint_check_origin(file, f->path, messages);
  if (status == SD_OK) status = summary_read(&f->found, file, messages);
  if (status == SD_OK && means == MEANS_ALL)
    status = summary_disks_read_all(&f->found.packing, file, messages);
  if (status == SD_OK && means == MEANS_ALL) complete_means(f, file, messages);
  if (status == SD_OK) provenance_read(&f->origin, file);
  if (status == SD_OK) status = h5_visit(file, add_dataset, f->datasets, messages);
  if (status == SD_OK) {
    f->parts = checkpoint_get_parts(file);
    f->finished = f->finished && f->parts < 0;
    if (file_is_folder(p->folder) && !f->finished) stored_tell_missing(p, f->parts, messages);
    f->bytes = file_size(f->path);
    f->clumps = h5_get_attr_i64(file, "/state", "n_clumps", 0);
    /* The path is only displayed after this: replace its control characters */
    text_clean(f->path);
  }
  h5_close(file, NULL);
  return status;
}

/* --- points of sweeps ------------------------------------------------------------------------- */

/* Returns why a sweep point (one run of a sweep) failed, from the file NAME.failed beside its
 * result; the caller frees the text. NULL: the point did not fail. */
static char *failure_of(const place *p) {
  char *path = NULL, *text = NULL;
  unsigned char *bytes = NULL;
  size_t size;
  if (text_ends(p->result, ".h5"))
    path = format_text("%.*s.failed", (int)(strlen(p->result) - strlen(".h5")), p->result);
  if (path && file_exists(path) && file_read(path, LIMIT_MIB, &bytes, &size, NULL) == SD_OK)
    text = text_clean(format_text("%.*s", (int)size, (const char *)bytes));
  free(bytes);
  free(path);
  return text;
}

static void print_failure(const char *text) {
  printf("FAILED when it was run last:\n");
  report_lines(stdout, "  ", text);
}

/* Prints why a sweep point failed if the point has neither a result nor a checkpoint. Returns true
 * if a reason was printed. */
static bool tell_failure(const char *name) {
  place p;
  bool told = false;
  sd_status status = place_find(&p, name, NULL);
  char *failure = p.result && status != SD_OK ? failure_of(&p) : NULL;
  if (failure) {
    printf("%s: there is no result\n", text_clean(p.result));
    print_failure(failure);
    told = true;
  }
  free(failure);
  place_free(&p);
  return told;
}

/* Returns SD_ERROR_USER, with a hint at the right commands, if `name` is the folder of a sweep;
 * else SD_OK. */
static sd_status refuse_sweep(const char *name, sd_messages *messages) {
  char *points = format_text("%s/points", name);
  bool found = file_is_folder(points);
  free(points);
  return !found ? SD_OK
                : sd_fail(messages, SD_ERROR_USER,
                          "%s is the folder of a sweep: slipdisk sweep DECK -o %s --status tells "
                          "how far it is, and "
                          "slipdisk info %s/points/NAME.h5 of a point",
                          name, name, name);
}

/* --- text output ------------------------------------------------------------------------------ */

static void print_text(const facts *f, const place *p) {
  const summary *s = &f->found;
  printf("%s: %s", f->path, *f->origin.title ? f->origin.title : "(no title)");
  if (f->finished)
    printf(", finished\n");
  else
    printf(", NOT finished: step %" PRId64 " %s %" PRId64 " (%.1f %%)%s%s, %" PRId64 " part%s\n",
           s->step, report_of(s), s->steps,
           100.0 * (double)s->step / (double)(s->steps > 0 ? s->steps : 1),
           *s->phase_name ? " in phase " : "", s->phase_name, f->parts, f->parts == 1 ? "" : "s");
  if (f->finished && file_is_folder(p->folder))
    printf("a newer run of it is not finished: slipdisk info %s.parts\n", f->path);
  char *failure = f->finished ? NULL : failure_of(p);
  if (failure) print_failure(failure);
  free(failure);
  printf("%" PRId64 " disks, ", s->disks);
  if (f->clumps) printf("%" PRId64 " clumps, ", f->clumps);
  printf("%" PRId64 " walls, %" PRId64 " contacts, dt %.6g, measured %.6g of %.6g\n", s->walls,
         s->contacts, s->dt, (double)s->measured * s->dt, (double)s->step * s->dt);
  report_summary(stdout, s);
  report_cost(stdout, s, &f->origin);
  printf("\nprovenance\n");
  for (size_t k = 0; k < provenance_text_count; k++)
    printf("  %-12s %s\n", provenance_texts[k].name, provenance_get(&f->origin, k));
  printf("  %-12s %" PRId64 "\n  %-12s %" PRId64 "\n", "seed", f->origin.seed, "sessions",
         f->origin.sessions);
  for (char *line = f->origin.deck_overrides; line && *line;) {
    int length = (int)strcspn(line, "\n");
    printf("  %-12s %.*s\n", "override", length, line);
    line += length + (line[length] == '\n');
  }
  printf("\ndatasets (%.3g MB)\n", (double)f->bytes / 1e6);
  size_t index;
  json_t *set;
  json_array_foreach(f->datasets, index, set) {
    const char *path = json_string_value(json_object_get(set, "path"));
    const char *last = strrchr(path, '/');
    /* Leave out columns of the state, and the step and time of each time series, which would be
     * most of the list. */
    if (strncmp(path, "/state/", 7) == 0 || strcmp(last, "/step") == 0 ||
        strcmp(last, "/time") == 0)
      continue;
    printf("  %-46s %-8s", path, json_string_value(json_object_get(set, "type")));
    const json_t *shape = json_object_get(set, "shape");
    for (size_t k = 0; k < json_array_size(shape); k++)
      printf("%s%" JSON_INTEGER_FORMAT, k ? " x " : " ",
             json_integer_value(json_array_get(shape, k)));
    putchar('\n');
  }
}

/* --- JSON output ------------------------------------------------------------------------------ */

/* Returns an array with an object for each of the two contacts of a watched disk: its name, and its
 * elements of the row. */
static json_t *contacts_json(const observable_list *list, const void *row, char *const *names) {
  json_t *contacts = json_array();
  for (size_t c = 0; c < 2; c++) {
    json_t *contact = json_pack("{s:s}", "name", names[1 + c]);
    json_add(contact, list, row, 2, c);
    json_array_append_new(contacts, contact);
  }
  return contacts;
}

/* Returns the quantity `name` of a sliding configuration as an array. */
static json_t *ages_json(const sd_configuration *c, const char *name) {
  const observable *o = observable_find(&configuration_observables, name);
  return json_elements(o, c, o->width);
}

/* Returns an array of the sliding configurations of watched disk w; empty if they were not
 * measured. */
static json_t *configurations_json(const summary *s, size_t w) {
  static const char *const names[] = {"S++", "S+-", "S-+", "S--", "stick", "open"};
  json_t *list = json_array();
  for (size_t k = SD_CONFIGURATIONS * w; k < s->n_configurations && k < SD_CONFIGURATIONS * (w + 1);
       k++) {
    const sd_configuration *c = &s->configurations[k];
    json_t *object = json_row(&configuration_observables, c);
    json_object_set_new(object, "name", json_string(names[k % SD_CONFIGURATIONS]));
    json_object_set_new(object, "contacts",
                        contacts_json(&configuration_observables, c, s->slide_names + 3 * w));
    json_object_set_new(object, "age_torque", ages_json(c, "age_torque"));
    json_object_set_new(object, "age_steps", ages_json(c, "age_steps"));
    json_array_append_new(list, object);
  }
  return list;
}

static json_t *slide_json(const summary *s) {
  json_t *list = json_array();
  for (size_t k = 0; k < s->n_slides; k++) {
    char *const *names = s->slide_names + 3 * k;
    json_t *object = json_row(&slide_observables, &s->slides[k]);
    json_object_set_new(object, "name", json_string(names[0]));
    json_object_set_new(object, "contacts",
                        contacts_json(&slide_observables, &s->slides[k], names));
    if (s->n_configurations)
      json_object_set_new(object, "configurations", configurations_json(s, k));
    json_array_append_new(list, object);
  }
  return list;
}

static json_t *until_json(const summary *s) {
  if (!s->has_until) return json_null();
  json_t *object = json_row(&until_observables, s);
  json_object_set_new(object, "observable", json_string(s->observable));
  json_object_set_new(object, "step",
                      s->until_step >= 0 ? json_integer(s->until_step) : json_null());
  return object;
}

/* Returns an object with the totals over all disks, and for each mean an array with an element per
 * disk; JSON null if there are no means. */
static json_t *disks_json(const summary *s) {
  const summary_disks *p = &s->packing;
  if (p->n == 0) return json_null();
  json_t *object = json_pack("{s:o, s:I, s:I, s:o}", "measured", json_number(p->measured), "looks",
                             (json_int_t)p->looks, "bins", (json_int_t)p->bins, "totals",
                             json_row(&total_observables, &p->totals));
  for (size_t k = 0; k < disk_observables.n; k++) {
    const observable *o = &disk_observables.rows[k];
    json_t *values = json_array();
    for (size_t i = 0; i < p->n; i++)
      json_array_append_new(values, json_observable(o, &p->disks[i], 0));
    json_object_set_new(object, o->name, values);
  }
  return object;
}

static json_t *doubts_json(const summary *s) {
  json_t *list = json_array();
  for (size_t k = 0; k < DOUBT_KINDS; k++) {
    const summary_doubt *d = &s->doubts[k];
    if (d->text)
      json_array_append_new(list, json_pack("{s:s, s:s, s:o, s:o}", "name", doubt_kinds[k].name,
                                            "message", d->text, "value", json_number(d->value),
                                            "limit", json_number(d->limit)));
  }
  return list;
}

static json_t *provenance_json(const provenance *p) {
  json_t *object = json_object();
  for (size_t k = 0; k < provenance_text_count; k++)
    json_object_set_new(object, provenance_texts[k].name,
                        json_string_nocheck(provenance_get(p, k)));
  json_object_set_new(object, "overrides",
                      json_string_nocheck(p->deck_overrides ? p->deck_overrides : ""));
  json_object_set_new(object, "seed", json_integer(p->seed));
  json_add(object, &provenance_observables, p, 1, 0);
  return object;
}

static json_t *facts_json(const facts *f) {
  const summary *s = &f->found;
  json_t *root = json_pack("{s:s, s:b}", "file", f->path, "finished", (int)f->finished);
  json_add(root, &fact_observables, s, 1, 0);
  json_add(root, &outcome_observables, s, 1, 0);
  const struct {
    const char *name;
    json_t *value;
  } rest[] = {{"clumps", json_integer(f->clumps)},
              {"phase_name", json_string(s->phase_name)},
              {"rotation", json_rotations(s)},
              {"averages", json_averages(s)},
              {"until", until_json(s)},
              {"sliding", slide_json(s)},
              {"means", disks_json(s)},
              {"energy", json_row(&energy_observables, &s->energy)},
              {"doubts", doubts_json(s)},
              {"provenance", provenance_json(&f->origin)},
              {"datasets", json_incref(f->datasets)}};
  for (size_t k = 0; k < sizeof rest / sizeof *rest; k++)
    json_object_set_new(root, rest[k].name, rest[k].value);
  return root;
}

/* --- command ---------------------------------------------------------------------------------- */

typedef struct arguments {
  size_t first; /* Index in argv of the first FILE; 0: none was given */
  bool json, deck, as_read, names;
} arguments;

static const option_row rows[] = {
    {"json", 0, OPTION_FLAG, offsetof(arguments, json), NULL, NULL,
     "for programs; of several files an array"},
    {"deck", 0, OPTION_FLAG, offsetof(arguments, deck), NULL, NULL,
     "the complete deck it was run with"},
    {"deck-as-read", 0, OPTION_FLAG, offsetof(arguments, as_read), NULL, NULL,
     "the deck as it was written, without -D and the point of a sweep"},
    {"names", 0, OPTION_FLAG, offsetof(arguments, names), NULL, NULL,
     "print the tables of all observables, and nothing else"},
    CONFINED_OPTION,
};
const command_line app_info_line = {
    .name = "info",
    .n = sizeof rows / sizeof *rows,
    .rows = rows,
    .operand = OPERAND_RESULTS,
    .offset = offsetof(arguments, first),
    .optional = true,
    .operands = "FILE...",
    .summary = "Tells what a run has found, finished or not",
    .examples = "slipdisk info deck.h5                   # means with error bars, energy budget\n"
                "slipdisk info deck.h5 --json\n"};

/* Prints the tables of all observables; tools/docs/names.py copies them into docs/names.md. */
static int print_names(void) {
  const observable_list *const lists[] = {
      &energy_observables,        &series_observables,     &frame_observables,
      &clump_observables,         &contact_observables,    &fact_observables,
      &outcome_observables,       &rotation_observables,   &slide_observables,
      &configuration_observables, &average_observables,    &phase_observables,
      &until_observables,         &disk_observables,       &total_observables,
      &provenance_observables,    &measurement_observables};
  for (size_t k = 0; k < sizeof lists / sizeof *lists; k++) observable_print(stdout, lists[k]);
  return SD_OK;
}

/* Prints one run as text if `into` is NULL; else appends it as an object to the JSON array `into`.
 * Returns the exit status. */
static int tell_file(const char *name, const arguments *a, json_t *into) {
  bool text = a->deck || a->as_read;
  if (!into && !text && tell_failure(name)) return SD_OK;
  place p = {0};
  facts f = {0};
  sd_messages *messages = sd_messages_new();
  int status = refuse_sweep(name, messages);
  if (status == SD_OK) status = place_find(&p, name, messages);
  bool named_parts = status == SD_OK && file_is_folder(name);
  if (status == SD_OK)
    status =
        read_facts(&f, &p, named_parts, into && !text ? MEANS_ALL : MEANS_AS_WRITTEN, messages);
  sd_messages_print(messages, stderr);
  if (status == SD_OK && text)
    fputs(a->deck ? f.origin.deck_full : f.origin.deck_text, stdout);
  else if (status == SD_OK && into)
    json_array_append_new(into, facts_json(&f));
  else if (status == SD_OK)
    print_text(&f, &p);
  facts_free(&f);
  place_free(&p);
  sd_messages_free(messages);
  return status;
}

/* Prints the only element of the list if several is false, else the whole list as an array. */
static int print_json(json_t *list, bool several) {
  const json_t *root = several ? list : json_array_get(list, 0);
  return root ? json_print(root) : SD_OK;
}

int app_info(int argc, char **argv) {
  arguments a = {0};
  int status = options_parse(&app_info_line, argc, argv, &a), n = a.first ? argc - (int)a.first : 0;
  if (status) return status;
  if (a.names) return print_names();
  if (n == 0) return app_misuse("info", "a result is expected");
  if (n > 1 && (a.deck || a.as_read))
    return app_misuse("info", "--deck and --deck-as-read want one result");
  json_t *list = a.json && !a.deck && !a.as_read ? json_array() : NULL;
  for (int k = argc - n; k < argc; k++) {
    if (!list && k > argc - n) putchar('\n');
    int one = tell_file(argv[k], &a, list);
    if (status == SD_OK) status = one;
  }
  int printed = list ? print_json(list, n > 1) : SD_OK;
  json_decref(list);
  return status == SD_OK ? printed : status;
}
