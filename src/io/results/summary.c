/* summary.c: see summary.h. */
#include "io/results/summary.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "base/text.h"
#include "io/store/file.h"
#include "io/store/members.h"
#include "io/results/series.h"
#include "pack/rain.h"
#include "physics/step/outside.h"

static sd_status no_memory(sd_messages *messages) {
  return sd_fail(messages, SD_ERROR_IO, "no memory for the summary");
}

static sd_status allocate(summary *s, sd_messages *messages) {
  s->rotations = calloc(s->n_rotations + 1, sizeof *s->rotations);
  s->rotation_names = calloc(s->n_rotations + 1, sizeof *s->rotation_names);
  s->slides = calloc(s->n_slides + 1, sizeof *s->slides);
  s->slide_names = calloc(3 * s->n_slides + 1, sizeof *s->slide_names);
  s->stages = calloc(s->n_stages + 1, sizeof *s->stages);
  s->stage_names = calloc(s->n_stages + 1, sizeof *s->stage_names);
  bool good = s->rotations && s->rotation_names && s->slides && s->slide_names && s->stages && s->stage_names;
  return good ? SD_OK : no_memory(messages);
}

/* The name that the deck gives, else "disk 17". */
static char *name_of(const sd_model *model, uint32_t body) {
  char text[80];
  const char *own =
      body < model->n_disks ? model->disks[body].name : model->walls[body - model->n_disks].name;
  if (own && *own) return format_text("%s", own);
  return format_text("%s", sd_model_body_name(model, body, text, sizeof text));
}

static sd_status collect_stages(summary *s, const sd_model *model, const sd_state *state,
                                sd_messages *messages) {
  bool named = true;
  for (size_t k = 0; k < s->n_stages; k++) {
    const sd_phase *p = &model->phases[k];
    s->stages[k] = (summary_phase){
        .steps = state->phase_steps[k],
        .most = p->steps,
        .asked = (p->settle.asked ? SUMMARY_SETTLE : 0) | (p->compress.asked ? SUMMARY_COMPRESS : 0),
        .reached = state->phase_reached[k],
        .kinetic = state->phase_kinetic[k],
        .kinetic_goal = p->settle.kinetic,
        .unbalanced = state->phase_unbalanced[k],
        .unbalanced_goal = p->settle.unbalanced,
        .target = state->phase_target[k],
        .target_goal = p->compress.pressure > 0.0 ? p->compress.pressure : p->compress.fraction};
    s->stage_names[k] = p->name ? format_text("%s", p->name) : format_text("%zu", k);
    named = named && s->stage_names[k];
  }
  return named ? SD_OK : no_memory(messages);
}

/* Which disks are outside, and where. */
static sd_status collect_lost(summary *s, const sd_model *model, const sd_state *state,
                              sd_messages *messages) {
  int told = 0;
  s->outside = outside_count(state);
  s->left = state->outside;
  s->waiting = rain_waiting(model, state);
  s->lost = format_text("%s", "");
  for (size_t i = 0; s->lost && i < state->n_free && told < OUTSIDE_TOLD; i++) {
    if (state->activity[i] != SD_OUTSIDE && state->activity[i] != SD_REMOVED) continue;
    char name[96];
    s->lost =
        append_text(s->lost, "%s%s at (%.6g, %.6g)", told++ ? ", " : "",
                    sd_model_body_name(model, state->id[i], name, sizeof name), state->x[i], state->y[i]);
  }
  return s->lost ? SD_OK : no_memory(messages);
}

static sd_status collect_until(summary *s, const sd_model *model, const sd_state *state,
                               sd_messages *messages) {
  const sd_until *u = &model->until;
  s->has_until = u->asked;
  s->until_step = -1;
  if (!u->asked) return SD_OK;
  uint32_t disk = model->rotations[u->rotation];
  const char *name = model->disks[disk].name, *what = u->scaled ? "scaled" : "omega";
  s->observable = name ? format_text("%s.%s", name, what) : format_text("%u.%s", disk, what);
  s->relative = u->relative > 0 ? u->relative : NAN;
  s->goal = sd_goal_of(model, state);
  if (s->goal.reached && s->phase == s->phases) s->until_step = s->step;
  return s->observable ? SD_OK : no_memory(messages);
}

sd_status summary_collect(summary *s, const sd_model *model, const sd_state *state, const sd_energy *energy,
                          double step_nanoseconds, sd_messages *messages) {
  *s = (summary){.step = state->step,
                 .steps = sd_model_steps(model),
                 .dt = model->dt,
                 .phase = state->phase,
                 .phases = (int64_t)model->n_phases,
                 .measured = state->measured,
                 .disks = (int64_t)model->n_disks,
                 .walls = (int64_t)model->n_walls,
                 .contacts = (int64_t)state->n_contacts,
                 .step_nanoseconds = step_nanoseconds,
                 .energy = *energy,
                 .n_rotations = model->n_rotations,
                 .n_slides = model->n_slides,
                 .n_stages = model->n_phases};
  bool running = state->phase >= 0 && (size_t)state->phase < model->n_phases;
  const char *phase = running ? model->phases[state->phase].name : NULL;
  s->phase_name = format_text("%s", phase ? phase : "");
  sd_status status = allocate(s, messages);
  if (status != SD_OK || !s->phase_name) return no_memory(messages);

  bool named = true;
  for (size_t k = 0; k < s->n_rotations; k++) {
    s->rotations[k] = sd_rotation_of(model, state, k);
    s->rotation_names[k] = name_of(model, model->rotations[k]);
    named = named && s->rotation_names[k];
  }
  for (size_t k = 0; k < s->n_slides; k++) {
    const sd_slide_watch *watch = &model->slides[k];
    s->slides[k] = sd_slide_of(model, state, k);
    s->slide_names[3 * k] = name_of(model, watch->disk);
    for (size_t p = 0; p < 2; p++) s->slide_names[3 * k + 1 + p] = name_of(model, watch->partner[p]);
    for (size_t p = 0; p < 3; p++) named = named && s->slide_names[3 * k + p];
  }
  status = named ? collect_until(s, model, state, messages) : no_memory(messages);
  if (status == SD_OK) status = collect_stages(s, model, state, messages);
  if (status == SD_OK) status = collect_lost(s, model, state, messages);
  if (status == SD_OK) status = summary_disks_collect(&s->packing, model, state, messages);
  return status == SD_OK ? summary_judge(s, &model->limits, model, state, messages) : status;
}

void summary_free(summary *s) {
  summary_disks_free(&s->packing);
  summary_doubts_free(s);
  for (size_t k = 0; s->rotation_names && k < s->n_rotations; k++) free(s->rotation_names[k]);
  for (size_t k = 0; s->slide_names && k < 3 * s->n_slides; k++) free(s->slide_names[k]);
  for (size_t k = 0; s->stage_names && k < s->n_stages; k++) free(s->stage_names[k]);
  free(s->stage_names);
  free(s->stages);
  free(s->lost);
  free(s->rotation_names);
  free(s->slide_names);
  free(s->rotations);
  free(s->slides);
  free(s->phase_name);
  free(s->observable);
  *s = (summary){0};
}

/* --- tables of what is stored --------------------------------------------------------------------- */

static const member rotation_members[] = {
    {"disk", SD_U32, offsetof(sd_rotation, disk), 1, "1", "body number"},
    {"omega", SD_F64, offsetof(sd_rotation, omega), 1, "rad/time", "mean angular velocity Omega"},
    {"error", SD_F64, offsetof(sd_rotation, error), 1, "rad/time", "one standard error of omega (blocking)"},
    {"scaled", SD_F64, offsetof(sd_rotation, scaled), 1, "rad", "t_g Omega, t_g = sqrt(2 R/g)"},
    {"scaled_error", SD_F64, offsetof(sd_rotation, scaled_error), 1, "rad", "one standard error of scaled"},
    {"transient", SD_F64, offsetof(sd_rotation, transient), 1, "time",
     "measured time discarded as transient"},
    {"measured", SD_F64, offsetof(sd_rotation, measured), 1, "time", "measured time, with the transient"},
    {"turned", SD_F64, offsetof(sd_rotation, turned), 1, "rad", "angle turned over the measured time"},
};

static const member slide_members[] = {
    {"disk", SD_U32, offsetof(sd_slide, disk), 1, "1", "body number"},
    {"partner", SD_U32, offsetof(sd_slide, partner), 2, "1", "body numbers"},
    {"pp", SD_F64, offsetof(sd_slide, pp), 1, "1", "fraction of measured steps in S++"},
    {"pm", SD_F64, offsetof(sd_slide, pm), 1, "1", "fraction of measured steps in S+-"},
    {"mp", SD_F64, offsetof(sd_slide, mp), 1, "1", "fraction of measured steps in S-+"},
    {"mm", SD_F64, offsetof(sd_slide, mm), 1, "1", "fraction of measured steps in S--"},
    {"stick", SD_F64, offsetof(sd_slide, stick), 1, "1", "fraction: at least one contact stuck, none open"},
    {"open", SD_F64, offsetof(sd_slide, open), 1, "1", "fraction: at least one contact open"},
    {"contact_positive", SD_F64, offsetof(sd_slide, contact_positive), 2, "1", "fraction: slides, tau > 0"},
    {"contact_negative", SD_F64, offsetof(sd_slide, contact_negative), 2, "1", "fraction: slides, tau < 0"},
    {"contact_stuck", SD_F64, offsetof(sd_slide, contact_stuck), 2, "1", "fraction: stuck"},
    {"contact_open", SD_F64, offsetof(sd_slide, contact_open), 2, "1", "fraction: open"},
    {"force_min", SD_F64, offsetof(sd_slide, force_min), 2, "force", "smallest normal force"},
    {"openings", SD_I64, offsetof(sd_slide, openings), 2, "1", "times the contact opened"},
};

static const member stage_members[] = {
    {"steps", SD_I64, offsetof(summary_phase, steps), 1, "1", "steps that the phase took, 0: not over"},
    {"most", SD_I64, offsetof(summary_phase, most), 1, "1", "its length, the most it may take"},
    {"asked", SD_I32, offsetof(summary_phase, asked), 1, "1", "to settle 1, to compress 2, both 3"},
    {"reached", SD_I32, offsetof(summary_phase, reached), 1, "1", "1: ended with what was asked for"},
    {"kinetic", SD_F64, offsetof(summary_phase, kinetic), 1, "energy", "kinetic energy per disk at the end"},
    {"kinetic_goal", SD_F64, offsetof(summary_phase, kinetic_goal), 1, "energy", "asked for; 0: nothing"},
    {"unbalanced", SD_F64, offsetof(summary_phase, unbalanced), 1, "1",
     "mean resultant force on a disk over mean contact force at the end"},
    {"unbalanced_goal", SD_F64, offsetof(summary_phase, unbalanced_goal), 1, "1", "asked for; 0: nothing"},
    {"target", SD_F64, offsetof(summary_phase, target), 1, "force/length or 1",
     "compression: pressure or packing fraction at the end"},
    {"target_goal", SD_F64, offsetof(summary_phase, target_goal), 1, "force/length or 1",
     "asked for; 0: nothing"},
};

enum {
  ROTATION_MEMBERS = sizeof rotation_members / sizeof *rotation_members,
  SLIDE_MEMBERS = sizeof slide_members / sizeof *slide_members,
  STAGE_MEMBERS = sizeof stage_members / sizeof *stage_members
};

/* --- names: one text, a line each ------------------------------------------------------------------ */

static void write_names(h5_file *file, const char *path, size_t n, char *const *names) {
  size_t total = 1;
  for (size_t k = 0; k < n; k++) total += strlen(names[k]) + 1;
  char *text = malloc(total), *at = text;
  if (!h5_have(file, text, path)) return;
  for (size_t k = 0; k < n; k++) {
    size_t length = strlen(names[k]);
    memcpy(at, names[k], length);
    at += length;
    *at++ = '\n';
  }
  *at = 0;
  h5_put_text(file, path, text);
  free(text);
}

/* Missing lines become empty names. */
static sd_status read_names(const h5_file *file, const char *path, size_t n, char **names,
                            sd_messages *messages) {
  char *text = h5_get_text(file, path);
  const char *at = text ? text : "";
  sd_status status = SD_OK;
  for (size_t k = 0; k < n; k++) {
    size_t length = strcspn(at, "\n");
    names[k] = format_text("%.*s", (int)length, at);
    if (!names[k]) status = no_memory(messages);
    at += length;
    if (*at) at++;
  }
  free(text);
  return status;
}

/* --- until ---------------------------------------------------------------------------------------- */

static const struct real {
  const char *name;
  size_t offset;
} until_reals[] = {
    {"value", offsetof(summary, goal.value)},       {"error", offsetof(summary, goal.error)},
    {"goal", offsetof(summary, goal.goal)},         {"relative", offsetof(summary, relative)},
    {"measured", offsetof(summary, goal.measured)},
};
enum { UNTIL_REALS = sizeof until_reals / sizeof *until_reals };

static void write_until(const summary *s, h5_file *file) {
  if (!s->has_until) return;
  h5_group(file, "/summary/until");
  h5_attr_text(file, "/summary/until", "observable", s->observable);
  for (size_t k = 0; k < UNTIL_REALS; k++) {
    double value;
    memcpy(&value, (const char *)s + until_reals[k].offset, sizeof value);
    h5_attr_f64(file, "/summary/until", until_reals[k].name, value);
  }
  h5_attr_i64(file, "/summary/until", "converged", s->goal.converged);
  h5_attr_i64(file, "/summary/until", "reached", s->until_step >= 0);
  h5_attr_i64(file, "/summary/until", "step", s->until_step);
}

static sd_status read_until(summary *s, const h5_file *file, sd_messages *messages) {
  s->has_until = h5_exists(file, "/summary/until");
  s->until_step = -1;
  if (!s->has_until) return SD_OK;
  for (size_t k = 0; k < UNTIL_REALS; k++) {
    double value = h5_get_attr_f64(file, "/summary/until", until_reals[k].name, NAN);
    memcpy((char *)s + until_reals[k].offset, &value, sizeof value);
  }
  s->goal.converged = h5_get_attr_i64(file, "/summary/until", "converged", 0) != 0;
  s->goal.reached = s->goal.converged && s->goal.error <= s->goal.goal;
  s->until_step = h5_get_attr_i64(file, "/summary/until", "step", -1);
  s->observable = h5_get_attr_text(file, "/summary/until", "observable");
  return s->observable ? SD_OK : sd_fail(messages, SD_ERROR_IO, "the summary is damaged");
}

/* --- whole ---------------------------------------------------------------------------------------- */

static const struct fact {
  const char *name;
  size_t offset;
} facts[] = {
    {"step", offsetof(summary, step)},         {"steps", offsetof(summary, steps)},
    {"phase", offsetof(summary, phase)},       {"phases", offsetof(summary, phases)},
    {"measured", offsetof(summary, measured)}, {"disks", offsetof(summary, disks)},
    {"walls", offsetof(summary, walls)},       {"contacts", offsetof(summary, contacts)},
    {"waiting", offsetof(summary, waiting)},   {"outside", offsetof(summary, outside)},
    {"left", offsetof(summary, left)},
};
enum { FACTS = sizeof facts / sizeof *facts };

void summary_write(const summary *s, h5_file *file) {
  h5_group(file, "/summary/energy");
  for (size_t k = 0; k < FACTS; k++) {
    int64_t value;
    memcpy(&value, (const char *)s + facts[k].offset, sizeof value);
    h5_attr_i64(file, "/summary", facts[k].name, value);
  }
  h5_attr_f64(file, "/summary", "dt", s->dt);
  h5_attr_f64(file, "/summary", "time", (double)s->step * s->dt);
  h5_attr_f64(file, "/summary", "step_nanoseconds", s->step_nanoseconds);
  h5_attr_text(file, "/summary", "phase_name", s->phase_name);
  h5_attr_text(file, "/summary", "lost", s->lost);
  for (size_t k = 0; k < series_energy_count; k++)
    h5_attr_f64(file, "/summary/energy", series_energies[k].name, series_energy_value(&s->energy, k));

  members_write(file, "/summary/rotation", rotation_members, ROTATION_MEMBERS, s->rotations,
                sizeof *s->rotations, s->n_rotations);
  int32_t *converged = calloc(s->n_rotations + 1, sizeof *converged);
  for (size_t k = 0; converged && k < s->n_rotations; k++) converged[k] = s->rotations[k].converged;
  if (h5_have(file, converged, "/summary/rotation"))
    h5_put(file, "/summary/rotation/converged", SD_I32, 1, &s->n_rotations, converged, true);
  free(converged);
  write_names(file, "/summary/rotation/name", s->n_rotations, s->rotation_names);
  h5_attr_i64(file, "/summary/rotation", "count", (int64_t)s->n_rotations);

  members_write(file, "/summary/slide", slide_members, SLIDE_MEMBERS, s->slides, sizeof *s->slides,
                s->n_slides);
  write_names(file, "/summary/slide/name", 3 * s->n_slides, s->slide_names);
  h5_attr_i64(file, "/summary/slide", "count", (int64_t)s->n_slides);
  members_write(file, "/summary/phase", stage_members, STAGE_MEMBERS, s->stages, sizeof *s->stages,
                s->n_stages);
  write_names(file, "/summary/phase/name", s->n_stages, s->stage_names);
  h5_attr_i64(file, "/summary/phase", "count", (int64_t)s->n_stages);
  write_until(s, file);
  summary_disks_write(&s->packing, file);
  summary_doubts_write(s, file);
}

/* Sizes that the file gives, and room for what they count. */
static sd_status read_counts(summary *s, const h5_file *file, sd_messages *messages) {
  const struct {
    const char *group, *first;
    size_t *count;
  } lists[] = {{"/summary/rotation", "/summary/rotation/disk", &s->n_rotations},
               {"/summary/slide", "/summary/slide/disk", &s->n_slides},
               {"/summary/phase", "/summary/phase/steps", &s->n_stages}};
  for (size_t k = 0; k < sizeof lists / sizeof *lists; k++) {
    int64_t n = h5_exists(file, lists[k].group) ? h5_get_attr_i64(file, lists[k].group, "count", 0) : 0;
    if (n < 0 || (n > 0 && h5_check(file, lists[k].first, (size_t)n, messages) != SD_OK))
      return sd_fail(messages, SD_ERROR_IO, "the summary is damaged");
    *lists[k].count = (size_t)n;
  }
  return allocate(s, messages);
}

sd_status summary_read(summary *s, const h5_file *file, sd_messages *messages) {
  *s = (summary){0};
  if (!h5_exists(file, "/summary"))
    return sd_fail(messages, SD_ERROR_USER, "this is not a result of slipdisk: there is no /summary in it");
  for (size_t k = 0; k < FACTS; k++) {
    int64_t value = h5_get_attr_i64(file, "/summary", facts[k].name, 0);
    memcpy((char *)s + facts[k].offset, &value, sizeof value);
  }
  s->dt = h5_get_attr_f64(file, "/summary", "dt", NAN);
  s->step_nanoseconds = h5_get_attr_f64(file, "/summary", "step_nanoseconds", NAN);
  s->phase_name = h5_get_attr_text(file, "/summary", "phase_name");
  if (!s->phase_name) s->phase_name = format_text("%s", "");
  for (size_t k = 0; k < series_energy_count; k++) {
    double value = h5_get_attr_f64(file, "/summary/energy", series_energies[k].name, NAN);
    memcpy((char *)&s->energy + series_energies[k].offset, &value, sizeof value);
  }
  s->lost = h5_get_attr_text(file, "/summary", "lost");
  if (!s->lost) s->lost = format_text("%s", "");
  sd_status status = s->lost ? read_counts(s, file, messages) : no_memory(messages);
  if (status == SD_OK)
    status = members_read(file, "/summary/rotation", rotation_members, ROTATION_MEMBERS, s->rotations,
                          sizeof *s->rotations, s->n_rotations, messages);
  int32_t *converged = calloc(s->n_rotations + 1, sizeof *converged);
  if (status == SD_OK && converged)
    status = h5_get(file, "/summary/rotation/converged", SD_I32, s->n_rotations, converged, messages);
  for (size_t k = 0; status == SD_OK && converged && k < s->n_rotations; k++)
    s->rotations[k].converged = converged[k] != 0;
  free(converged);
  if (status == SD_OK)
    status = members_read(file, "/summary/slide", slide_members, SLIDE_MEMBERS, s->slides, sizeof *s->slides,
                          s->n_slides, messages);
  if (status == SD_OK)
    status = read_names(file, "/summary/rotation/name", s->n_rotations, s->rotation_names, messages);
  if (status == SD_OK)
    status = read_names(file, "/summary/slide/name", 3 * s->n_slides, s->slide_names, messages);
  if (status == SD_OK && s->n_stages > 0)
    status = members_read(file, "/summary/phase", stage_members, STAGE_MEMBERS, s->stages, sizeof *s->stages,
                          s->n_stages, messages);
  if (status == SD_OK && s->n_stages > 0)
    status = read_names(file, "/summary/phase/name", s->n_stages, s->stage_names, messages);
  if (status == SD_OK) status = read_until(s, file, messages);
  if (status == SD_OK) status = summary_disks_read(&s->packing, file, messages);
  if (status == SD_OK) status = summary_doubts_read(s, file, messages);
  return status;
}
