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
                   (int)LK_BVH_QUAD == (int)LAYOUT_QUAD &&
                   (int)LK_BVH_COMPRESSED == (int)LAYOUT_COMPRESSED,
               "layouts are numbered alike");
_Static_assert((int)LK_RAYS_COUNT == (int)RAY_CLASSES, "rays are told apart alike");

// A way to trace that GPUs may take.
struct candidate {
    enum lk_trace trace;
    enum lk_bvh bvh;
    unsigned with_votes, without; // uses where warps vote, and where they do not
};

#define BOTH (FORM_TRACES | FORM_SHADOWS)

// The plainest first. An H100 traces camera rays in Sponza, Sibenik and a level of 45,000 triangles
// fastest by binary simple (0.42, 0.28, 0.27 ms for 2 M rays; quad warps 0.49, 0.35, 0.33), later
// bounces by quad warps in the former (0.86, 0.85; binary postponing 0.97, 1.00) and by binary
// postponing in the latter (0.42; 0.43). Binary warps and quad postponing come within 2 % of the
// best at most, and are left out: NVIDIA's compiler takes one kernel at a time, a form of trace 0.3
// s, one of the kernels of shadow rays 0.9 s. Those therefore follow later bounces, which they do
// in all three scenes when they are measured, too.
static const struct candidate candidates[] = {
    {LK_TRACE_SIMPLE, LK_BVH_BINARY, FORM_TRACES, BOTH},
    {LK_TRACE_SIMPLE, LK_BVH_QUAD, 0, BOTH},
    {LK_TRACE_PERSISTENT, LK_BVH_BINARY, 0, BOTH},
    {LK_TRACE_PERSISTENT, LK_BVH_QUAD, 0, BOTH},
    {LK_TRACE_POSTPONING, LK_BVH_BINARY, FORM_TRACES | FORM_FOLLOWS, 0},
    {LK_TRACE_WARPS, LK_BVH_QUAD, FORM_TRACES | FORM_FOLLOWS, 0},
};

const struct form *choice_candidates;
uint32_t choice_candidate_count;

// ---- Forms

static bool is_same(const struct form *a, const struct form *b)
{
    return a->trace == b->trace && a->bvh == b->bvh && a->more == b->more;
}

bool form_has(const struct form *form, enum ray_class class)
{
    const unsigned uses = class == RAYS_SHADOW ? FORM_SHADOWS | FORM_FOLLOWS : FORM_TRACES;
    return (form->uses & uses) != 0;
}

void choice_follow(struct choice *choice)
{
    const enum lk_bvh bvh = choice->forms[choice->of[RAYS_LATER_BOUNCES]].bvh;
    for (uint32_t i = 0; i < choice->form_count; i++)
        if (choice->forms[i].bvh == bvh && (choice->forms[i].uses & FORM_FOLLOWS)) {
            choice->of[RAYS_SHADOW] = i;
            choice->reasons[RAYS_SHADOW] = choice->reasons[RAYS_LATER_BOUNCES];
        }
}

const char *form_name(char *out, size_t size, const struct form *form)
{
    snprintf(out, size, "%s %s%s%s", choices_bvh[form->bvh], choices_trace[form->trace],
             form->more != NULL ? " " : "", form->more != NULL ? form->more : "");
    return out;
}

// ---- What there is to choose among

// Adds a form, or its uses if it is there. Returns its index.
static uint32_t add_form(struct choice *choice, const struct form *form)
{
    uint32_t i = 0;
    while (i < choice->form_count && !is_same(&choice->forms[i], form))
        i++;
    if (i < choice->form_count)
        choice->forms[i].uses |= form->uses;
    else
        choice->forms[choice->form_count++] = *form;
    return i;
}

static void add_candidates(struct choice *choice, const struct lk_settings *asked,
                           const struct lk_settings *rule, const struct gpu *gpu)
{
    for (uint32_t i = 0; i < choice_candidate_count; i++)
        add_form(choice, &choice_candidates[i]);
    if (gpu->info.is_cpu || choice_candidate_count > 0)
        return;
    const bool votes = rule->trace == LK_TRACE_POSTPONING || rule->trace == LK_TRACE_WARPS ||
                       program_takes_votes(gpu);
    for (size_t i = 0; i < sizeof(candidates) / sizeof(candidates[0]); i++) {
        const struct candidate *c = &candidates[i];
        const struct form form = {c->trace, c->bvh, votes ? c->with_votes : c->without, NULL};
        if (form.uses != 0 && (asked->trace == LK_TRACE_AUTO || asked->trace == form.trace) &&
            (asked->bvh == LK_BVH_AUTO || asked->bvh == form.bvh))
            add_form(choice, &form);
    }
}

// Whether there is more than one way to trace rays of some kind, and the first form traces paths.
static bool is_open(const struct choice *choice)
{
    uint32_t counts[RAY_CLASSES] = {0};
    bool open = false;
    for (int c = 0; c < RAY_CLASSES; c++) {
        for (uint32_t i = 0; i < choice->form_count; i++)
            counts[c] += form_has(&choice->forms[i], (enum ray_class)c);
        open = open || counts[c] > 1;
    }
    return open && form_has(&choice->forms[0], RAYS_CAMERA);
}

void choice_begin(struct choice *out, const struct lk_settings *asked,
                  const struct lk_settings *rule, const struct gpu *gpu)
{
    const struct form ruled = {rule->trace, rule->bvh, FORM_TRACES, NULL};
    const struct form shadows = {rule->trace, rule->bvh, FORM_SHADOWS, NULL};
    const bool forced = asked->trace != LK_TRACE_AUTO && asked->bvh != LK_BVH_AUTO;
    *out = (struct choice){0};
    if (!forced && rule->nodes == LK_NODES_BUFFER)
        add_candidates(out, asked, rule, gpu);
    for (int c = 0; c < RAY_CLASSES; c++) {
        out->of[c] = add_form(out, c == RAYS_SHADOW ? &shadows : &ruled);
        out->reasons[c] = forced ? LK_REASON_FORCED : LK_REASON_RULE;
    }
    out->open = is_open(out);
    if (gpu->info.is_cpu && out->form_count == 1 && asked->trace == LK_TRACE_AUTO &&
        !asked->profile)
        out->fusion = FUSION_PATHS;
}

void choice_fall_back(struct choice *choice)
{
    const struct form plain = {LK_TRACE_SIMPLE, choice->forms[choice->of[RAYS_LATER_BOUNCES]].bvh,
                               BOTH, NULL};
    choice->forms[0] = plain;
    choice->form_count = 1;
    choice->fusion = FUSION_NONE;
    choice->open = choice->broken = false;
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

// ---- What lights a scene

// Whether light comes from far away, as far as can be told before it is prepared.
static bool has_far_lights(const struct lk_scene *scene, const struct lk_settings *s)
{
    const float *color = s->background;
    return scene->prepared.emitters.directional_count > 0 || s->env != NULL ||
           s->sky_sun_deg[1] != 0.0f || color[0] + color[1] + color[2] > 0.0f ||
           scene->scene.environment.width > 0;
}

static bool has_lights(const struct lk_scene *scene, const struct lk_settings *s)
{
    return scene->prepared.emitters.light_count > 0 || has_far_lights(scene, s);
}

// ---- Bounces by one kernel

// What a scene has at most. An H100 renders a box of 32 triangles 56 % faster by one kernel a
// bounce than by stages, of 670 with balls in it 25 %, of 3,900 5 %, of 16,000 0 %, of 80,000 9 %
// slower: long rays want more warps side by side than the registers of the whole bounce leave.
// Rooms of 500 triangles gain 12 to 20 % with 100 or 1000 lights, but lose 4 to 6 % where those are
// drawn by importance, many at once.
#define FUSED_TRIANGLES 4096u
#define FUSED_LIGHTS    8u // drawn by importance

bool choice_always_fuses;

static bool is_small(const struct gpu *gpu, const struct lk_scene *scene,
                     const struct lk_settings *rule)
{
    return !gpu->info.is_cpu && scene->prepared.geometry.triangle_count <= FUSED_TRIANGLES &&
           (rule->light_sampler != LK_LIGHTS_IMPORTANCE ||
            scene->prepared.emitters.light_count <= FUSED_LIGHTS);
}

bool choice_fuse(struct choice *choice, const struct gpu *gpu, const struct lk_scene *scene,
                 const struct lk_settings *rule)
{
    // The plainest form needs no probe.
    uint32_t plain = 0;
    while (plain < choice->form_count && (choice->forms[plain].trace != LK_TRACE_SIMPLE ||
                                          choice->forms[plain].bvh != LK_BVH_BINARY))
        plain++;
    if (plain == choice->form_count || rule->profile || rule->textures == LK_TEXTURES_BOUND ||
        scene->prepared.emitters.light_count == 0 || has_far_lights(scene, rule) ||
        !(choice_always_fuses || is_small(gpu, scene, rule)))
        return false;
    choice->fusion = FUSION_BOUNCES;
    choice->open = false;
    for (int c = 0; c < RAY_CLASSES; c++) {
        choice->of[c] = plain;
        if (choice->reasons[c] != LK_REASON_FORCED)
            choice->reasons[c] = LK_REASON_RULE;
    }
    return true;
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
        if (of[c] == choice->form_count || !form_has(&choice->forms[of[c]], (enum ray_class)c))
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
