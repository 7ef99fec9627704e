/**
 * @file
 * What the kernels of tests share.
 */
#ifndef TESTS_DEVICE_TEST_H
#define TESTS_DEVICE_TEST_H

#define WG_TEST 32 // work items in a group

// A kernel of a test: one item a case; items past the last case do nothing.
#define TEST_KERNEL __kernel __attribute__((reqd_work_group_size(WG_TEST, 1, 1))) void

#endif
