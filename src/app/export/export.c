/* export.c: the subcommand `slipdisk export FILE --to FORMAT`; see export.h and docs/export.md. */
#include "app/export/export.h"

#include <assert.h>
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "app/app.h"
#include "base/text.h"
#include "io/store/file.h"

#define FORMAT_NAMES "h5md3d|lammps-dump|lammps-data|extxyz|vtk|csv"

static const struct format {
  const char *name, *ending;
  /* True: the format stores one frame, by default the last one */
  bool single;
  bool folder;
  export_writer *write;
} formats[] = {
    {"h5md3d", "h5md", false, false, export_h5md},
    {"lammps-dump", "dump", false, false, export_dump},
    {"lammps-data", "data", true, false, export_data},
    {"extxyz", "extxyz", false, false, export_xyz},
    {"vtk", "vtk", false, true, export_vtk},
    {"csv", "tables", false, true, export_csv},
};
enum { FORMATS = sizeof formats / sizeof *formats };

typedef struct arguments {
  const char *name, *format, *output, *frames;
} arguments;

static const option_row rows[] = {
    {"to", 0, OPTION_CHOICE, offsetof(arguments, format),
     &(option_limits){0, 0,
                      "; OVITO reads extxyz and lammps-dump, ParaView vtk, MDAnalysis h5md3d, ASE "
                      "extxyz"},
     FORMAT_NAMES, "what it is written as; must be given"},
    {"output", 'o', OPTION_PATH, offsetof(arguments, output), NULL, "OUT",
     "file, or folder of vtk and csv; by default the name of FILE with the format's ending, in the "
     "current "
     "folder"},
    {"frames", 0, OPTION_TEXT, offsetof(arguments, frames), NULL, "RANGE",
     "a frame (5, -1 the last) or FIRST:END:STEP as slices in Python; by default all, of "
     "lammps-data the "
     "last"},
    CONFINED_OPTION,
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
            "  vtk          folder with vtp files and pvd lists of disks, contacts, walls: "
            "ParaView, VTK\n"
            "  csv          folder with tables of disks, contacts, series\n",
    .examples = "slipdisk export deck.h5 --to csv                        # the folder deck.tables\n"
                "slipdisk export deck.h5 --to vtk --frames ::10          # every tenth frame, for "
                "ParaView\n"
                "slipdisk export deck.h5 --to lammps-data -o start.data  # the last frame\n"};

/* --- command ---------------------------------------------------------------------------------- */

static int parse(int argc, char **argv, arguments *a, const struct format **format) {
  int mistake = options_parse(&app_export_line, argc, argv, a);
  if (mistake) return mistake;
  for (size_t k = 0; a->format && k < FORMATS; k++)
    if (strcmp(formats[k].name, a->format) == 0) *format = &formats[k];
  return *format ? 0
                 : app_misuse("export", "the format is not said; expected --to %s", FORMAT_NAMES);
}

static sd_status check_output(const export_job *job, const struct format *format) {
  if (format->folder || !file_is_folder(job->out)) return SD_OK;
  return sd_fail(job->messages, SD_ERROR_USER, "-o %s is a folder; expected the name of a file",
                 job->out);
}

static sd_status check_single(const export_job *job, const char *format, const arguments *a) {
  if (job->range.n == 1) return SD_OK;
  return sd_fail(job->messages, SD_ERROR_USER,
                 "--frames %s chooses %zu frames; %s takes one, such as --frames %zu", a->frames,
                 job->range.n, format, job->range.first);
}

/* Returns the default path of the output, such as "r.extxyz" for the input ".../r.h5" or
 * ".../r.h5.parts/"; the caller frees it. */
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
  export_job job = {
      .source = a->name, .out = a->output ? a->output : named, .f = &f, .messages = messages};
  sd_status status = options_range(a->frames, SIZE_MAX, a->name, &syntax, messages);
  if (status == SD_OK) status = stored_open(&f, a->name, &alone, messages);
  if (status == SD_OK) status = stored_count(&f, alone, &count, messages);
  const char *range = a->frames ? a->frames : format->single ? "-1" : NULL;
  if (status == SD_OK) status = options_range(range, count, a->name, &job.range, messages);
  if (status == SD_OK && format->single) status = check_single(&job, format->name, a);
  job.m = f.constants;
  if (status == SD_OK) status = check_output(&job, format);
  if (status == SD_OK) status = export_find_types(&job);
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
