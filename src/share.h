/**
 * @file
 * A render shared among several devices, each with a thread, programs, a scene and a film of its
 * own.
 *
 * The samples of a picture are taken in rounds over its pixels. Within a round a device that
 * is free takes the next pixels and all their samples of the round, at most half of its share of
 * what is left by the speeds measured so far (guided self-scheduling, C. Polychronopoulos and
 * D. Kuck, 1987), so that spans become short towards the end of a round and all end together; a
 * device so slow that the others are done before its least span would be takes none. The canvas
 * hands a pixel's sum from one round's device to the next one's. So a pixel's samples are added in
 * their order, as by one device, and devices that compute alike give the same bits however the
 * pixels were dealt out.
 *
 * Where the render is to end at a noise, on one device, too, film/noise.h decides on the pixels and
 * samples of a round.
 *
 * A device that is still being set up holds up nobody until the end, when it is waited for.
 */
#ifndef SHARE_H
#define SHARE_H

#include "render.h"

/** Renders on all devices of the render. Fails as render_paths(), naming the device. */
enum status share_paths(struct render *render);

#endif
