/**
 * @file
 * The start-up probe: which form of the kernels (choice.h) traces which rays fastest, measured on
 * the scene that is to be rendered.
 *
 * It takes batches of paths that nobody sees, larger and larger ones, through the pipeline's own
 * stages, and launches those that trace in every form there is, timed by events. A form that does
 * not end in time, or whose hits or light are not those of the plainest one, is struck out with a
 * warning; forms of shadow rays that do not agree all are if the plainest is none of them, and then
 * it traces everything. No count of steps in the kernels watches over them: their loops end by
 * construction, and what may hang in a warp is its waiting for votes, which only the host can see.
 */
#ifndef PROBE_H
#define PROBE_H

#include "renderer.h"

/** Limits, s; tests set others. */
struct probe_limits {
    double all;     // no batch is begun that would end later
    double launch;  // a form that takes longer is struck out
    double grace;   // after that, the device is given up
    double telling; // launches that take less tell of launching
};
extern struct probe_limits probe_limits;

/**
 * Decides an open choice: as equal devices did before in this process, or else by measuring. One
 * device at a time, so that none disturbs another.
 *
 * @param renderer    All but its film is set up, with all forms built.
 * @param[out] stuck  With a failure: a launch does not end, or went wrong. The device must not be
 * waited for, but may work when it is opened anew.
 * @retval STATUS_DEVICE  An OpenCL call failed, or a launch does not end.
 */
enum status probe_decide(struct renderer *renderer, bool *stuck);

#endif
