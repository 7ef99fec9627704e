#include "choice.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/choices.h"
#include "device/program.h"

#define NOTE_SIZE  512 // bytes of a note's text
#define NAME_SIZE  96
#define NOTES_MAX  64 // that a process remembers
#define NOTE_BEGIN "lightkiln tracing 1\n"

_Static_assert((int)LK_BVH_BINARY == (int)LAYOUT_BINARY && (int)LK_BVH_WIDE == (int)LAYOUT_WIDE &&
                   (int)LK_BVH_QUAD == (int)LAYOUT_QUAD,
               "layouts are numbered alike");
_Static_assert((int)LK_RAYS_COUNT == (int)RAY_CLASSES, "rays are told apart alike");

// What GPUs choose among, the plainest first. An H100 traces camera rays and first bounces in
// Sponza fastest by the binary BVH with postponing, later bounces by quad warps, shadow rays by
// quad postponing: 4683, 2211, 1876 and 5825 Mrays/s, against 4005, 2137, 1876 and 5440 by quad
// warps.
static const struct form candidates[] = {
    {LK_TRACE_SIMPLE, LK_BVH_BINARY, NULL},     {LK_TRACE_SIMPLE, LK_BVH_QUAD, NULL},
    {LK_TRACE_POSTPONING, LK_BVH_BINARY, NULL}, {LK_TRACE_POSTPONING, LK_BVH_QUAD, NULL},
    {LK_TRACE_WARPS, LK_BVH_BINARY, NULL},      {LK_TRACE_WARPS, LK_BVH_QUAD, NULL},
    {LK_TRACE_PERSISTENT, LK_BVH_BINARY, NULL}, {LK_TRACE_PERSISTENT, LK_BVH_QUAD, NULL},
};

const struct form *choice_candidates;
uint32_t choice_candidate_count;

// ---- Forms

static bool is_same(const struct form *a, const struct form *b)
{
    return a->trace == b->trace && a->bvh == b->bvh && a->more == b->more;
}

// Only rays that are traced alone can refill a warp (cl/lib/trace_refill.h); with others, a queue
// for each warp is slower than none.
static struct form shadow_form(const struct form *form)
{
    struct form own = *form;
    if (own.bvh == LK_BVH_QUAD && own.trace == LK_TRACE_WARPS)
        own.trace = LK_TRACE_POSTPONING;
    return own;
}

bool form_has_shadows(const struct form *form)
{
    const struct form own = shadow_form(form);
    return is_same(form, &own);
}

const char *form_name(char *out, size_t size, const struct form *form)
{
    snprintf(out, size, "%s %s%s%s", choices_bvh[form->bvh], choices_trace[form->trace],
             form->more != NULL ? " " : "", form->more != NULL ? form->more : "");
    return out;
}

// ---- What there is to choose among

static bool takes_votes(const struct form *form)
{
    return form->trace == LK_TRACE_POSTPONING || form->trace == LK_TRACE_WARPS;
}

// Whether a form is worth a trial. Where warps vote, what gets along without is there to check the
// others by.
static bool is_candidate(const struct form *form, const struct lk_settings *asked, bool votes)
{
    if ((asked->trace != LK_TRACE_AUTO && form->trace != asked->trace) ||
        (asked->bvh != LK_BVH_AUTO && form->bvh != asked->bvh))
        return false;
    if (takes_votes(form))
        return votes;
    const bool is_plainest =
        form->trace == LK_TRACE_SIMPLE && (form->bvh == LK_BVH_BINARY || asked->bvh == form->bvh);
    return !votes || asked->trace == form->trace || is_plainest;
}

// The index of a form, which is added if it is not there.
static uint32_t add_form(struct choice *choice, const struct form *form)
{
    for (uint32_t i = 0; i < choice->form_count; i++)
        if (is_same(&choice->forms[i], form))
            return i;
    choice->forms[choice->form_count] = *form;
    return choice->form_count++;
}

static void add_candidates(struct choice *choice, const struct lk_settings *asked,
                           const struct lk_settings *rule, const struct gpu *gpu)
{
    const struct form ruled = {rule->trace, rule->bvh, NULL};
    if (choice_candidates != NULL) {
        for (uint32_t i = 0; i < choice_candidate_count; i++)
            add_form(choice, &choice_candidates[i]);
        return;
    }
    if (gpu->info.is_cpu)
        return;
    const bool votes = takes_votes(&ruled) || program_takes_votes(gpu);
    for (size_t i = 0; i < sizeof(candidates) / sizeof(candidates[0]); i++)
        if (is_candidate(&candidates[i], asked, votes))
            add_form(choice, &candidates[i]);
}

void choice_begin(struct choice *out, const struct lk_settings *asked,
                  const struct lk_settings *rule, const struct gpu *gpu)
{
    const struct form ruled = {rule->trace, rule->bvh, NULL};
    const struct form shadows = shadow_form(&ruled);
    const bool forced = asked->trace != LK_TRACE_AUTO && asked->bvh != LK_BVH_AUTO;
    *out = (struct choice){0};
    if (!forced && rule->nodes == LK_NODES_BUFFER)
        add_candidates(out, asked, rule, gpu);
    out->open = out->form_count > 1;
    for (int c = 0; c < RAY_CLASSES; c++) {
        out->of[c] = add_form(out, c == RAYS_SHADOW ? &shadows : &ruled);
        out->reasons[c] = forced ? LK_REASON_FORCED : LK_REASON_RULE;
    }
}

void choice_fall_back(struct choice *choice)
{
    const struct form plain = {LK_TRACE_SIMPLE, choice->forms[choice->of[RAYS_LATER_BOUNCES]].bvh,
                               NULL};
    choice->forms[0] = plain;
    choice->form_count = 1;
    choice->open = false;
    for (int c = 0; c < RAY_CLASSES; c++) {
        choice->of[c] = 0;
        choice->reasons[c] = LK_REASON_RULE;
    }
}

unsigned choice_layouts(const struct choice *choice)
{
    unsigned layouts = 0;
    for (uint32_t i = 0; i < choice->form_count && choice->open; i++)
        layouts |= 1u << choice->forms[i].bvh;
    for (int c = 0; c < RAY_CLASSES; c++)
        layouts |= 1u << choice->forms[choice->of[c]].bvh;
    return layouts;
}

bool choice_has_layouts(const struct choice *choice)
{
    const unsigned layouts = choice_layouts(choice);
    return (layouts & (layouts - 1)) != 0;
}

// ---- What was found before

// Notes of this process, each with its key.
static struct {
    pthread_mutex_t lock;
    struct build_key keys[NOTES_MAX];
    char notes[NOTES_MAX][NOTE_SIZE];
    uint32_t count;
} remembered = {.lock = PTHREAD_MUTEX_INITIALIZER};

static void write_line(char *out, size_t size, const struct choice *choice, int class,
                       uint32_t form)
{
    char name[NAME_SIZE];
    snprintf(out, size, "%s %s\n", choices_rays[class],
             form_name(name, sizeof(name), &choice->forms[form]));
}

static void write_note(char *out, const struct choice *choice)
{
    char line[NAME_SIZE + 32];
    strcpy(out, NOTE_BEGIN);
    for (int c = 0; c < RAY_CLASSES; c++) {
        write_line(line, sizeof(line), choice, c, choice->of[c]);
        strncat(out, line, NOTE_SIZE - strlen(out) - 1);
    }
}

// Takes what a note says. False, and nothing is taken, if it is not exactly one of what could be.
static bool read_note(struct choice *choice, const char *note)
{
    uint32_t of[RAY_CLASSES];
    if (strncmp(note, NOTE_BEGIN, strlen(NOTE_BEGIN)) != 0)
        return false;
    note += strlen(NOTE_BEGIN);
    for (int c = 0; c < RAY_CLASSES; c++) {
        char line[NAME_SIZE + 32];
        for (of[c] = 0; of[c] < choice->form_count; of[c]++) {
            write_line(line, sizeof(line), choice, c, of[c]);
            if (strncmp(note, line, strlen(line)) == 0)
                break;
        }
        if (of[c] == choice->form_count ||
            (c == RAYS_SHADOW && !form_has_shadows(&choice->forms[of[c]])))
            return false;
        note += strlen(line);
    }
    if (*note != '\0')
        return false;
    for (int c = 0; c < RAY_CLASSES; c++) {
        choice->of[c] = of[c];
        choice->reasons[c] = LK_REASON_CACHE;
    }
    choice->open = false;
    return true;
}

// The note of a key, or a free one, in which nothing is written; NULL if all are taken.
static char *find_remembered(const struct build_key *key)
{
    for (uint32_t i = 0; i < remembered.count; i++)
        if (memcmp(&remembered.keys[i], key, sizeof(*key)) == 0)
            return remembered.notes[i];
    return remembered.count < NOTES_MAX ? remembered.notes[remembered.count] : NULL;
}

static void remember(const struct build_key *key, const char *text)
{
    pthread_mutex_lock(&remembered.lock);
    char *note = find_remembered(key);
    if (note != NULL) {
        if (note == remembered.notes[remembered.count])
            remembered.keys[remembered.count++] = *key;
        snprintf(note, NOTE_SIZE, "%s", text);
    }
    pthread_mutex_unlock(&remembered.lock);
}

bool choice_recall_again(struct choice *choice, bool no_cache)
{
    pthread_mutex_lock(&remembered.lock);
    const char *note = find_remembered(&choice->key);
    bool found = note != NULL && read_note(choice, note);
    pthread_mutex_unlock(&remembered.lock);
    if (found || no_cache)
        return found;
    char *text = build_cache_note_load(&choice->key);
    found = text != NULL && read_note(choice, text);
    if (found)
        remember(&choice->key, text);
    free(text);
    return found;
}

void choice_keep(const struct choice *choice, bool no_cache)
{
    char note[NOTE_SIZE];
    write_note(note, choice);
    remember(&choice->key, note);
    if (!no_cache)
        build_cache_note_save(&choice->key, note);
}

void choice_forget(void)
{
    pthread_mutex_lock(&remembered.lock);
    memset(remembered.notes, 0, sizeof(remembered.notes));
    remembered.count = 0;
    pthread_mutex_unlock(&remembered.lock);
}

// Whether there are lights, as far as can be told before they are prepared.
static bool has_lights(const struct lk_scene *scene, const struct lk_settings *s)
{
    const struct emitters *emitters = &scene->prepared.emitters;
    const float *color = s->background;
    return emitters->light_count > 0 || emitters->directional_count > 0 || s->env != NULL ||
           s->sky_sun_deg[1] != 0.0f || color[0] + color[1] + color[2] > 0.0f ||
           scene->scene.environment.width > 0;
}

void choice_recall(struct choice *choice, const struct gpu *gpu, const struct lk_scene *scene,
                   const struct lk_settings *settings)
{
    if (!choice->open)
        return;
    uint32_t size = 0; // of the scene: log4 of its triangles
    for (uint32_t rest = scene->prepared.geometry.triangle_count; rest >= 4; rest /= 4)
        size++;
    char about[256 + PIPELINE_FORMS_MAX * NAME_SIZE];
    int used = snprintf(about, sizeof(about), "tracing, 4^%u triangles, %u bounces, %s", size,
                        settings->depth < 3 ? settings->depth : 3,
                        has_lights(scene, settings) ? "lit" : "dark");
    for (uint32_t i = 0; i < choice->form_count; i++) {
        char name[NAME_SIZE];
        used += snprintf(about + used, sizeof(about) - (size_t)used, ", %s",
                         form_name(name, sizeof(name), &choice->forms[i]));
    }
    build_cache_note_key(&choice->key, gpu, about);
    choice_recall_again(choice, settings->no_cache);
}
