/* manual.c: prints manual pages, and a script for completion in bash; see app.h. */
#include "app/app.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

#include "base/text.h"
#include "io/deck/deck.h"
#include "version.h"

typedef struct manual_row {
  const char *name, *text;
} manual_row;

static const manual_row statuses[] = {
    {"0", "done"},
    {"2", "mistake in deck or command"},
    {"3", "numerical error"},
    {"4", "input or output failed, or no memory"},
    {"5", "done, but the result is in doubt (energy budget, open contacts, disks too fast: see its "
          "warnings)"},
    {"6", "`sweep --no-wait`: done but for points that other processes run"},
    {"75", "stopped by a signal after a checkpoint (INT, TERM, HUP, USR1, USR2, XCPU, ALRM): give "
           "the command "
           "again to continue"},
};

static const manual_row environment[] = {
    {"OMP_NUM_THREADS",
     "most threads that are chosen where `--threads` does not say; by default the cores"},
    {"SLIPDISK_AUTHOR",
     "the author's name in results; by default that of the account, of root \"unknown\""},
    {"SLIPDISK_CHUNK",
     "disks that a step treats while they are in the cache, and lets systems of four such chunks "
     "take several steps at once, to the same bits; for tests"},
    {"SLIPDISK_CONFINED",
     "a folder: decks read no file outside of it (`--confined` sets it to that of the deck)"},
    {"SLIPDISK_PATH",
     "instruction set of the kernels, `baseline`, `avx2` or `avx512`, to the same bits; by "
     "default the best that the machine has"},
    {"SLIPDISK_PYTHON",
     "the interpreter that `plot` and `film` run, with numpy, h5py and matplotlib; by default "
     "/usr/bin/python3, else python3"},
    {"SLIPDISK_WINDOWS",
     "`always` or `never`: whether systems of 20,000 disks and more take several steps at once, "
     "chunk by chunk, to the same bits; by default what is measured to be faster"},
    {"SLIPDISK_LIBRARY",
     "the shared library that the Python package loads; by default that of its installation"},
    {"SLIPDISK_PROGRAM",
     "the program that the Python package runs; by default that of its installation"},
};

static const manual_row files[] = {
    {"NAME.cfg", "a deck: disks, walls, materials, motions and phases of a run, or a sweep"},
    {"NAME.h5", "a result (HDF5, H5MD), written when the run has finished"},
    {"NAME.h5.parts/", "an unfinished run: checkpoints, and what has been recorded so far"},
    {"NAME.sweep/", "a sweep: its points, and tables of their results (`means.csv`)"},
    {"/usr/share/slipdisk/inputs/",
     "decks that ship, and programs that use the library (the prefix of the "
     "installation may be another)"},
    {"/usr/share/doc/slipdisk/", "the documentation (the same)"},
};

#define ROWS(table) (sizeof(table) / sizeof *(table)), table

void manual_statuses(FILE *out) {
  fputs("Exit status:\n", out);
  for (size_t k = 0; k < sizeof statuses / sizeof *statuses; k++) {
    char head[16];
    snprintf(head, sizeof head, "  %s", statuses[k].name);
    options_entry(out, head, statuses[k].text, 6);
  }
}

/* --- manual pages ----------------------------------------------------------------------------- */

enum { MAN_WIDTH = 68 };

/* Prints n bytes of text, escaped for troff. Text between backquotes is printed bold; *bold: true
 * if the position is inside backquotes, kept between calls. */
static void man_bytes(FILE *out, const char *text, size_t n, bool *bold) {
  for (size_t k = 0; k < n; k++) switch (text[k]) {
      case '\\': fputs("\\e", out); break;
      case '-': fputs("\\-", out); break;
      case '`': fputs((*bold = !*bold) ? "\\fB" : "\\fR", out); break;
      default: fputc(text[k], out);
    }
}

static void man_text(FILE *out, const char *text) {
  bool bold = false;
  size_t at = 0;
  for (text += strspn(text, " \n"); *text; text += strspn(text, " \n")) {
    size_t n = strcspn(text, " \n");
    if (at > 0 && at + 1 + n > MAN_WIDTH) {
      fputc('\n', out);
      at = 0;
    }
    if (at > 0) fputc(' ', out);
    if (at == 0 && (*text == '.' || *text == '\'')) fputs("\\&", out);
    man_bytes(out, text, n, &bold);
    at += n + 1;
    text += n;
  }
  fputc('\n', out);
}

/* Prints text for troff as filled paragraphs; indented lines keep their line breaks. */
static void man_lines(FILE *out, const char *text) {
  bool bold = false, table = false;
  char *prose = NULL;
  for (size_t n; *text; text += n + (text[n] == '\n')) {
    n = strcspn(text, "\n");
    if (*text != ' ') {
      if (table) fputs(".fi\n.PP\n", out);
      table = false;
      prose = prose ? append_text(prose, " %.*s", (int)n, text) : format_text("%.*s", (int)n, text);
      continue;
    }
    if (prose) man_text(out, prose);
    free(prose);
    prose = NULL;
    if (!table) fputs(".PP\n.nf\n", out);
    table = true;
    man_bytes(out, text, n, &bold);
    fputc('\n', out);
  }
  if (prose) man_text(out, prose);
  if (table) fputs(".fi\n", out);
  free(prose);
}

/* Prints a tagged paragraph of troff (.TP): `head` in bold, then the text. */
static void man_entry(FILE *out, const char *head, const char *text) {
  bool bold = false;
  fputs(".TP\n\\fB", out);
  man_bytes(out, head, strlen(head), &bold);
  fputs("\\fR\n", out);
  man_text(out, text);
}

static void man_rows(FILE *out, const char *title, size_t n, const manual_row *rows) {
  fprintf(out, ".SH %s\n", title);
  for (size_t k = 0; k < n; k++) man_entry(out, rows[k].name, rows[k].text);
}

/* Prints an option as a tagged paragraph of troff (.TP), with the name of its value in italics, or
 * with the words of a choice in bold. */
static void man_option(FILE *out, const option_row *row) {
  bool bold = false;
  fputs(".TP\n", out);
  if (row->letter) fprintf(out, "\\fB\\-%c\\fR, ", row->letter);
  fputs("\\fB\\-\\-", out);
  man_bytes(out, row->name, strlen(row->name), &bold);
  fputs("\\fR", out);
  if (row->value) {
    fputs(row->kind == OPTION_CHOICE ? " \\fB" : " \\fI", out);
    man_bytes(out, row->value, strlen(row->value), &bold);
    fputs("\\fR", out);
  }
  fputc('\n', out);
  man_text(out, row->help);
}

static void man_examples(FILE *out, const char *examples) {
  bool bold = false;
  fputs(".SH EXAMPLES\n.nf\n", out);
  for (const char *text = examples; *text; text += strspn(text, "\n")) {
    size_t n = strcspn(text, "\n");
    man_bytes(out, text, n, &bold);
    fputc('\n', out);
    text += n;
  }
  fputs(".fi\n", out);
}

/* Prints the head of a manual page. command: name of the subcommand, "" for slipdisk(1). line: its
 * summary, whose first letter is printed in lower case. */
static void man_head(FILE *out, const char *command, const char *line) {
  char title[64], name[64];
  bool bold = false;
  snprintf(name, sizeof name, *command ? "slipdisk\\-%s" : "slipdisk", command);
  snprintf(title, sizeof title, *command ? "SLIPDISK\\-%s" : "SLIPDISK", command);
  for (char *c = title; *c; c++) *c = (char)toupper((unsigned char)*c);
  fprintf(out, ".TH %s 1 %s \"slipdisk %s\" \"slipdisk\"\n.SH NAME\n%s \\- %c", title,
          SD_VERSION_DATE, SD_VERSION, name, tolower((unsigned char)*line));
  man_bytes(out, line + 1, strlen(line + 1), &bold);
  fputc('\n', out);
}

void manual_command(FILE *out, const command_line *line) {
  static const option_row help = {
      .name = "help", .letter = 'h', .help = "the options, on the screen"};
  man_head(out, line->name, line->summary);
  fprintf(out, ".SH SYNOPSIS\n\\fBslipdisk %s\\fR [\\fIoptions\\fR] \\fI%s\\fR\n.SH DESCRIPTION\n",
          line->name, line->operands);
  char *text = format_text("%s.\n%s", line->summary, line->more ? line->more : "");
  man_lines(out, text);
  free(text);
  fputs(".SH OPTIONS\n", out);
  for (size_t k = 0; k < line->n; k++) man_option(out, &line->rows[k]);
  man_option(out, &help);
  man_rows(out, "EXIT STATUS", ROWS(statuses));
  if (line->examples) man_examples(out, line->examples);
  fputs(".SH SEE ALSO\n.BR slipdisk (1)\nfor environment and files\n", out);
}

void manual_overview(FILE *out, size_t n, const command_line *const *lines) {
  man_head(out, "", "Frictional disks in two dimensions");
  fputs(".SH SYNOPSIS\n\\fBslipdisk\\fR \\fICOMMAND\\fR [\\fIoptions\\fR] ...\n"
        ".br\n\\fBslipdisk\\fR \\fICOMMAND\\fR \\fB\\-\\-help\\fR\n"
        ".br\n\\fBslipdisk version\\fR\n.SH DESCRIPTION\n",
        out);
  man_text(out, "Follows disks that touch each other and walls through a normal spring (linear or "
                "Hertz), damped, "
                "and a tangential spring limited by friction, and measures how they rotate, slide "
                "and dissipate. "
                "A deck, a text file, says of which disks; a result is an HDF5 file. Runs survive "
                "being killed, "
                "and give the same bits on any number of threads.");
  fputs(".SH COMMANDS\n", out);
  for (size_t k = 0; k < n; k++) {
    fprintf(out, ".TP\n\\fBslipdisk\\-%s\\fR(1)\n", lines[k]->name);
    man_text(out, lines[k]->summary);
  }
  man_rows(out, "EXIT STATUS", ROWS(statuses));
  man_rows(out, "ENVIRONMENT", ROWS(environment));
  man_rows(out, "FILES", ROWS(files));
  man_examples(
      out,
      "slipdisk check deck.cfg                 # is the deck in order, how long will it take?\n"
      "slipdisk run deck.cfg                   # makes deck.h5; the same again continues a run\n"
      "slipdisk run deck.cfg -D seed=2 -o two.h5\n"
      "slipdisk info deck.h5                   # means with error bars, energy budget\n");
}

/* --- bash completion -------------------------------------------------------------------------- */

/* Prints for the completion script which value an option takes: "file", "folder", "text", or the
 * words of a choice, such as "csv,vtk"; "key": a path of the deck. */
static void bash_kind(FILE *out, const option_row *row) {
  const char *words = options_words(row);
  if (words)
    for (const char *c = words; *c; c++) fputc(*c == '|' ? ',' : *c, out);
  else if (strcmp(row->value, "PATH=VALUE") == 0)
    fputs("key", out);
  else if (row->kind == OPTION_PATH || row->kind == OPTION_RESULT || row->kind == OPTION_STREAM)
    fputs(strstr(row->value, "FOLDER") ? "folder" : "file", out);
  else
    fputs("text", out);
}

static void bash_command(FILE *out, const command_line *line) {
  fprintf(out, "    %s)\n      operands='%s'\n      options='--help -h", line->name,
          line->operands);
  for (size_t k = 0; k < line->n; k++) {
    const option_row *row = &line->rows[k];
    for (int letter = 0; letter <= (row->letter != 0); letter++) {
      fputc(' ', out);
      if (letter)
        fprintf(out, "-%c", row->letter);
      else
        fprintf(out, "--%s", row->name);
      if (row->value) fputc(':', out);
      if (row->value) bash_kind(out, row);
    }
  }
  fputs("' ;;\n", out);
}

static const char bash_code[] =
    "  esac\n"
    "}\n"
    "\n"
    "# Words that begin like $cur: files but those of a pattern, folders, others\n"
    "_slipdisk_files() {\n"
    "  compopt -o filenames 2>/dev/null\n"
    "  mapfile -t -O ${#COMPREPLY[@]} COMPREPLY < <(compgen -f -X \"$1\" -- \"$cur\")\n"
    "}\n"
    "_slipdisk_folders() {\n"
    "  compopt -o filenames 2>/dev/null\n"
    "  mapfile -t -O ${#COMPREPLY[@]} COMPREPLY < <(compgen -d -- \"$cur\")\n"
    "}\n"
    "_slipdisk_words() {\n"
    "  mapfile -t -O ${#COMPREPLY[@]} COMPREPLY < <(compgen -W \"$1\" -- \"$cur\")\n"
    "}\n"
    "\n"
    "_slipdisk() {\n"
    "  local cur=${COMP_WORDS[COMP_CWORD]} last=${COMP_WORDS[COMP_CWORD - 1]} operands= options= "
    "kind= row\n"
    "  COMPREPLY=()\n"
    "  if ((COMP_CWORD == 1)); then\n"
    "    _slipdisk_words \"$_slipdisk_commands --help --version\"\n"
    "    return\n"
    "  fi\n"
    "  # bash takes the = of --option=value for a word of its own\n"
    "  if [[ $cur == = ]]; then\n"
    "    cur=\n"
    "  elif [[ $last == = ]]; then\n"
    "    last=${COMP_WORDS[COMP_CWORD - 2]}\n"
    "    if [[ $last != -* ]]; then return; fi\n"
    "  fi\n"
    "  _slipdisk_rows \"${COMP_WORDS[1]}\"\n"
    "  for row in $options; do\n"
    "    if [[ ${row%%:*} == \"$last\" && $row == *:* ]]; then kind=${row#*:}; fi\n"
    "  done\n"
    "  if [[ -z $kind && $cur == -* ]]; then kind=option; fi\n"
    "  case $kind in\n"
    "    option) _slipdisk_words \"$(printf '%s\\n' $options | sed 's/:.*//')\" ;;\n"
    "    text) ;;\n"
    "    key)\n"
    "      compopt -o nospace 2>/dev/null\n"
    "      mapfile -t COMPREPLY < <(compgen -S = -W \"$_slipdisk_keys\" -- \"$cur\") ;;\n"
    "    folder) _slipdisk_folders ;;\n"
    "    file) _slipdisk_files '' ;;\n"
    "    ?*) _slipdisk_words \"${kind//,/ }\" ;;\n"
    "    *)\n"
    "      if [[ $operands == *DECK* ]]; then _slipdisk_files '!*.cfg'; fi\n"
    "      if [[ $operands == *FILE* ]]; then _slipdisk_files '!*.h5'; fi\n"
    "      if [[ $operands == *COMMAND* ]]; then _slipdisk_words \"$_slipdisk_commands\"; fi\n"
    "      if [[ $operands == *DECK* || $operands == *FILE* || $operands == *SWEEP* ]]; then "
    "_slipdisk_folders; fi ;;\n"
    "  esac\n"
    "}\n"
    "complete -F _slipdisk slipdisk\n";

void manual_bash(FILE *out, size_t n, const command_line *const *lines) {
  fputs("# bash completion for slipdisk, written by `slipdisk help "
        "--bash`\n_slipdisk_commands='version",
        out);
  for (size_t k = 0; k < n; k++) fprintf(out, " %s", lines[k]->name);
  fputs("'\n_slipdisk_keys='", out);
  deck_paths_print(out);
  fputs("'\n\n_slipdisk_rows() {\n  case $1 in\n", out);
  for (size_t k = 0; k < n; k++) bash_command(out, lines[k]);
  fputs(bash_code, out);
}
