#include "cli/progress.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#define LINE_INTERVAL_S 5.0 // between whole lines, so that a log of an hour stays readable

static volatile sig_atomic_t interrupted;

static void note_interrupt(int signal_number)
{
    (void)signal_number;
    interrupted = 1;
    signal(SIGINT, SIG_DFL);
    signal(SIGTERM, SIG_DFL);
}

void progress_catch_interrupts(void)
{
    // Also where a script's shell, which starts programs in the background, had them ignored: an
    // interrupt loses nothing.
    signal(SIGINT, note_interrupt);
    signal(SIGTERM, note_interrupt);
}

bool progress_is_interrupted(void)
{
    return interrupted != 0;
}

void progress_init(struct progress *progress, bool quiet, bool strict)
{
    const char *kind = getenv("TERM");
    *progress = (struct progress){.quiet = quiet, .strict = strict};
    progress->terminal = isatty(STDERR_FILENO) && kind != NULL && strcmp(kind, "dumb") != 0;
}

// "12.3 s", "3:07", "1:02:45"
static void format_time(char *text, size_t size, double seconds)
{
    const unsigned long whole = seconds < 1e9 ? (unsigned long)seconds : 1000000000;
    if (seconds < 59.95)
        snprintf(text, size, "%.1f s", seconds);
    else if (whole < 3600)
        snprintf(text, size, "%lu:%02lu min", whole / 60, whole % 60);
    else
        snprintf(text, size, "%lu:%02lu:%02lu h", whole / 3600, whole / 60 % 60, whole % 60);
}

static void format_line(char *text, size_t size, const struct lk_progress *now)
{
    char elapsed[32];
    char remaining[64] = "";
    char speed[512] = "";
    format_time(elapsed, sizeof(elapsed), now->elapsed_s);
    if (now->remaining_s >= 0.0) {
        format_time(remaining, sizeof(remaining) - 16, now->remaining_s);
        strcat(remaining, " left, ");
    }
    if (now->spp > 0.0)
        snprintf(speed, sizeof(speed), ", %.4g spp, %s elapsed, %s%.2f Mrays/s", now->spp, elapsed,
                 remaining, now->mrays_per_s);
    else
        snprintf(speed, sizeof(speed), ", %s elapsed", elapsed);
    snprintf(text, size, "lightkiln: %s %.0f %%%s", now->stage, 100.0 * now->fraction, speed);
}

bool progress_report(void *user, const struct lk_progress *now)
{
    struct progress *progress = user;
    if (!progress->quiet) {
        char line[768];
        format_line(line, sizeof(line), now);
        if (progress->terminal) {
            // A line that wraps cannot be rewritten: cut it to the window.
            struct winsize window = {0};
            const bool known = ioctl(STDERR_FILENO, TIOCGWINSZ, &window) == 0 && window.ws_col > 1;
            fprintf(stderr, "\r%.*s\033[K", known ? window.ws_col - 1 : 79, line);
            progress->line_shown = true;
        } else if (!progress->first_shown ||
                   now->elapsed_s - progress->shown_s >= LINE_INTERVAL_S) {
            fprintf(stderr, "%s\n", line);
            progress->shown_s = now->elapsed_s;
            progress->first_shown = true;
        }
        fflush(stderr);
    }
    return interrupted == 0 && !(progress->strict && lk_warning_count() > 0);
}

void progress_log(void *user, enum lk_log_level level, const char *message)
{
    static const char *const prefixes[] = {"error: ", "warning: ", "", ""};
    progress_end(user);
    fprintf(stderr, "lightkiln: %s%s\n", prefixes[level], message);
}

void progress_end(struct progress *progress)
{
    if (progress->line_shown)
        fprintf(stderr, "\r\033[K");
    progress->line_shown = false;
}
