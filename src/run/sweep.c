/* sweep.c: see sweep.h. State of a point: sweep_look.c. Points are run in sweep_points.c, the tables are
 * written by sweep_table.c. */
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/text.h"
#include "io/store/file.h"
#include "run/sweep_private.h"

sd_status sweep_open(sweep *s, const char *deck, size_t n_overrides, const char *const *overrides,
                     const char *place, sd_messages *messages) {
  *s = (sweep){.folder = memory_text(place)};
  return deck_sweep_load(deck, n_overrides, overrides, &s->deck, messages);
}

void sweep_close(sweep *s) {
  deck_sweep_free(&s->deck);
  free(s->folder);
  *s = (sweep){0};
}

/* --- checks ------------------------------------------------------------------------------------------------ */

/* Mistakes of the deck itself come with every point, and those of a path with every value. */
enum { MOST_MISTAKES = 40 };

typedef struct mistake {
  char *text;
  size_t point, sets; /* the first that makes it, and how many do */
} mistake;

typedef struct mistakes {
  size_t n, more; /* more: not kept */
  mistake list[MOST_MISTAKES];
} mistakes;

/* Cuts "file:line: path = value: what is wrong" up; false: it has another form. */
static bool cut(const char *text, const char **path, size_t *n, const char **wrong) {
  const char *equals = strstr(text, " = ");
  if (!equals) return false;
  for (*path = equals; *path > text && (*path)[-1] != ' ';) --*path;
  *n = (size_t)(equals - *path);
  *wrong = strrchr(equals, ':');
  return *wrong != NULL;
}

/* The same is wrong with the same path, whatever the value. */
static bool same_mistake(const char *a, const char *b) {
  const char *path, *other, *wrong, *amiss;
  size_t n, m;
  if (!cut(a, &path, &n, &wrong) || !cut(b, &other, &m, &amiss)) return strcmp(a, b) == 0;
  return n == m && strncmp(path, other, n) == 0 && strcmp(wrong, amiss) == 0;
}

static void note_mistake(mistakes *all, size_t point, const char *text) {
  for (size_t k = 0; k < all->n; k++)
    if (same_mistake(all->list[k].text, text)) {
      all->list[k].sets++;
      return;
    }
  if (all->n < MOST_MISTAKES)
    all->list[all->n++] = (mistake){memory_text(text), point, 1};
  else
    all->more++;
}

static void tell_mistakes(mistakes *all, const sweep *s, sd_messages *messages) {
  for (size_t k = 0; k < all->n; k++) {
    const mistake *m = &all->list[k];
    if (m->sets >= s->deck.n_sets)
      sd_fail(messages, SD_ERROR_USER, "%s", m->text);
    else if (m->sets == 1)
      sd_fail(messages, SD_ERROR_USER, "%s (point %zu, %s)", m->text, m->point,
              s->deck.points[m->point].name);
    else
      sd_fail(messages, SD_ERROR_USER, "%s (point %zu, %s, and others: %zu of %zu sets of values)", m->text,
              m->point, s->deck.points[m->point].name, m->sets, s->deck.n_sets);
    free(m->text);
  }
  if (all->more > 0) sd_fail(messages, SD_ERROR_USER, "%zu more mistakes of other points", all->more);
}

sd_status sweep_check(const sweep *s, sweep_visitor *visit, void *user, size_t *usable,
                      sd_messages *messages) {
  mistakes all = {0};
  sd_status status = SD_OK;
  unsigned char *seen = memory_new(s->deck.n_sets, 1);
  *usable = 0;
  for (size_t k = 0; k < s->deck.n_points && status != SD_ERROR_IO; k++) {
    size_t set = s->deck.points[k].set;
    if (seen[set]) continue;
    seen[set] = 1;
    sd_messages *mine = sd_messages_new();
    sd_model *model;
    sd_status one = deck_sweep_model(&s->deck, k, &model, mine);
    if (one == SD_OK && visit && visit(user, k, model)) model = NULL;
    *usable += one == SD_OK;
    if (one != SD_OK) status = one;
    for (size_t m = 0; one != SD_OK && m < sd_messages_count(mine); m++)
      note_mistake(&all, k, sd_messages_text(mine, m));
    sd_model_free(model);
    sd_messages_free(mine);
  }
  free(seen);
  tell_mistakes(&all, s, messages);
  return status;
}

sd_status sweep_prepare(const sweep *s, sd_messages *messages) {
  char *points = format_text("%s/points", s->folder);
  sd_status status = file_make_folder(s->folder, messages);
  if (status == SD_OK) status = file_make_folder(points, messages);
  free(points);
  return status;
}

/* --- for those who run points ------------------------------------------------------------------------------ */

void sweep_note(const sweep *s, size_t point, const char *text) {
  char *path = sweep_point_path(s, point, ".failed");
  if (text)
    file_write_atomic(path, text, strlen(text), NULL);
  else if (file_exists(path))
    file_remove(-1, path);
  free(path);
}

void sweep_note_messages(const sweep *s, size_t point, const sd_messages *messages) {
  char *text = memory_text("");
  for (size_t k = 0; k < sd_messages_count(messages); k++)
    text = append_text(text, "%s\n", sd_messages_text(messages, k));
  sweep_note(s, point, text);
  free(text);
}

sd_status sweep_load(const sweep *s, size_t point, sd_model **model, char **result, sd_messages *messages) {
  *model = NULL;
  *result = sweep_point_path(s, point, ".h5");
  return deck_sweep_model(&s->deck, point, model, messages);
}
