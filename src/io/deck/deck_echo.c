/* deck_echo.c: prints the tree of a deck, with all defaults, as a full deck. See deck_tree.h.
 *
 * Keys are printed in the order of their tables; values that were left out are marked "# default".
 * Reading the full deck gives the same model: numbers have the shortest digits that read back as
 * the same double, and integers beyond 32 bits have the suffix L. */
#include <stdio.h>
#include <string.h>

#include "base/memory.h"
#include "io/deck/deck_read.h"

enum { WIDTH = 110 };

typedef struct printer {
  deck *d;
  deck_buffer out;
  size_t line; /* Index in out.bytes of the start of the current line */
  bool one_line;
} printer;

static void put(printer *p, const char *text) {
  deck_put(p->d, &p->out, text, strlen(text));
  const char *end = strrchr(text, '\n');
  if (end) p->line = p->out.n - strlen(end) + 1;
}

static void newline(printer *p, int indent) {
  put(p, p->one_line ? " " : "\n");
  if (p->one_line) return;
  for (int k = 0; k < indent; k++) put(p, "  ");
}

static void put_text(printer *p, const char *text) {
  put(p, "\"");
  for (; *text; text++) {
    char escaped[8] = {*text, 0};
    unsigned char c = (unsigned char)*text;
    if (c == '"' || c == '\\')
      snprintf(escaped, sizeof escaped, "\\%c", c);
    else if (c == '\n')
      strcpy(escaped, "\\n");
    else if (c < 0x20 || c == 0x7f)
      snprintf(escaped, sizeof escaped, "\\x%02X", (unsigned)c);
    put(p, escaped);
  }
  put(p, "\"");
}

static void put_scalar(printer *p, const deck_node *node) {
  char text[40];
  switch (node->type) {
    case DECK_BOOL: put(p, node->value.flag ? "true" : "false"); break;
    case DECK_STRING:
      put_text(p, node->value.text);
      if (node->remark && !p->one_line) {
        put(p, " /* ");
        put(p, node->remark);
        put(p, " */");
      }
      break;
    case DECK_FLOAT: put(p, deck_number_text(node->value.number, text)); break;
    case DECK_INT: {
      int64_t x = node->value.integer;
      snprintf(text, sizeof text, "%lld%s", (long long)x,
               x > INT32_MAX || x < INT32_MIN ? "L" : "");
      put(p, text);
      break;
    }
    default: break;
  }
}

static bool scalar(const deck_node *node) {
  return node->type != DECK_GROUP && node->type != DECK_LIST;
}

static void put_group(printer *p, const deck_node *node, int indent);

static void put_value(printer *p, const deck_node *node, int indent) {
  if (scalar(node)) {
    put_scalar(p, node);
    return;
  }
  if (node->type == DECK_GROUP) {
    put(p, "{");
    put_group(p, node, indent);
    put(p, " }");
    return;
  }
  bool rows = node->n && (node->child[0]->type == DECK_GROUP ||
                          (node->child[0]->type == DECK_LIST && node->n > 4));
  put(p, "(");
  for (size_t k = 0; k < node->n; k++) {
    if (k) put(p, ",");
    if (rows || p->out.n - p->line > WIDTH)
      newline(p, indent + 1);
    else if (k)
      put(p, " ");
    put_value(p, node->child[k], indent + 1);
  }
  if (rows) newline(p, indent);
  put(p, ")");
}

/* Finds child k of a group, in the order of its key table if it has one; *child is NULL if the deck
 * lacks the key. Returns false if k is beyond the last key. */
static bool nth(const deck_node *group, size_t k, const deck_node **child) {
  const deck_key *key = group->table ? deck_key_at(group->table, k) : NULL;
  *child = group->table   ? (key ? deck_child(group, key->name) : NULL)
           : k < group->n ? group->child[k]
                          : NULL;
  return key || *child;
}

/* Prints "key = value;" for each key of a group, as many as fit on a line. */
static void put_group(printer *p, const deck_node *node, int indent) {
  const deck_node *child;
  for (size_t k = 0; nth(node, k, &child); k++) {
    if (!child) continue;
    if (p->out.n - p->line > WIDTH - 20 || (!scalar(child) && child->n && !scalar(child->child[0])))
      newline(p, indent + 1);
    else
      put(p, " ");
    put(p, child->name);
    put(p, " = ");
    put_value(p, child, indent + 1);
    put(p, ";");
  }
}

static void put_top(printer *p, const deck_node *child) {
  put(p, child->name);
  put(p, " = ");
  put_value(p, child, 0);
  put(p, ";");
  if (child->defaulted) put(p, "  # default");
  put(p, "\n");
}

const char *deck_value_text(deck *d, const deck_node *node) {
  printer p = {.d = d, .one_line = true};
  put_value(&p, node, 0);
  return p.out.bytes;
}

char *deck_echo(deck *d) {
  printer p = {.d = d};
  put(&p, "# full deck, with all defaults; written by slipdisk\n");
  const deck_node *child;
  for (size_t k = 0; nth(d->root, k, &child); k++)
    if (child) put_top(&p, child);
  return memory_text(p.out.bytes);
}
