/* deck_parse.c: converts libconfig's tree to nodes. The only file that uses libconfig. See
 * deck_tree.h.
 *
 * The text has been through deck_scan, so that every number fits its type and every line can be
 * traced back to its file. */
#include <libconfig.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "io/deck/deck_tree.h"

static deck_place place_of(const deck_text *text, unsigned line) {
  if (text->n_lines == 0) return (deck_place){NULL, 0};
  if (line < 1) line = 1;
  if (line > text->n_lines) line = (unsigned)text->n_lines;
  return text->line[line - 1];
}

static const char *name_of(deck *d, const config_setting_t *setting) {
  const char *name = config_setting_name(setting);
  return name ? deck_copy(d, name, strlen(name)) : NULL;
}

static deck_type type_of(const config_setting_t *setting) {
  switch (config_setting_type(setting)) {
    case CONFIG_TYPE_GROUP: return DECK_GROUP;
    case CONFIG_TYPE_INT:
    case CONFIG_TYPE_INT64: return DECK_INT;
    case CONFIG_TYPE_FLOAT: return DECK_FLOAT;
    case CONFIG_TYPE_BOOL: return DECK_BOOL;
    case CONFIG_TYPE_STRING: return DECK_STRING;
    default: return DECK_LIST;
  }
}

/* Copies a setting of libconfig and its children to nodes. If a text or name is missing, the
 * library ran out of memory. The scanner bounds the depth of the recursion. */
static void convert(deck *d, const deck_text *text, const config_setting_t *from, deck_node *to) {
  switch (to->type) {
    case DECK_BOOL: to->value.flag = config_setting_get_bool(from); return;
    case DECK_INT:
      to->value.integer = config_setting_type(from) == CONFIG_TYPE_INT
                              ? config_setting_get_int(from)
                              : config_setting_get_int64(from);
      return;
    case DECK_FLOAT: to->value.number = config_setting_get_float(from); return;
    case DECK_STRING: {
      const char *s = config_setting_get_string(from);
      if (!s) memory_lacks(0);
      to->value.text = deck_copy(d, s, strlen(s));
      deck_check_text(d, to);
      return;
    }
    case DECK_GROUP:
    case DECK_LIST: break;
  }
  int n = config_setting_length(from);
  for (int k = 0; k < n; k++) {
    const config_setting_t *child = config_setting_get_elem(from, (unsigned)k);
    const char *name = name_of(d, child);
    if (!name && to->type == DECK_GROUP) memory_lacks(0);
    /* Skip the second of two equal keys, which the scanner renamed and reported */
    if (name && strncmp(name, "*repeated-", 10) == 0) continue;
    deck_place place = place_of(text, config_setting_source_line(child));
    convert(d, text, child, deck_node_new(d, to, name, type_of(child), place));
  }
}

void deck_parse_free(deck *d) {
  if (!d->library) return;
  config_destroy(d->library);
  free(d->library);
  d->library = NULL;
}

deck_node *deck_parse(deck *d, const deck_text *text) {
  config_t *library = memory_new(1, sizeof *library);
  config_init(library);
  d->library = library;
  deck_node *root = NULL;
  if (config_read_string(library, text->clean)) {
    root = deck_node_new(d, NULL, NULL, DECK_GROUP, place_of(text, 1));
    convert(d, text, config_root_setting(library), root);
  } else {
    const char *what = config_error_text(library);
    deck_fail_place(d, place_of(text, (unsigned)config_error_line(library)),
                    "%s, here or on the line before (is a ; or a comma missing, or one too many?)",
                    what ? what : "syntax error");
  }
  deck_parse_free(d);
  return root;
}
