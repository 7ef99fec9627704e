/**
 * @file
 * Form factors of rectangles (J. R. Howell, "A Catalog of Radiation Heat Transfer Configuration
 * Factors").
 */
#ifndef TESTS_ENGINE_FORM_FACTOR_H
#define TESTS_ENGINE_FORM_FACTOR_H

#include <math.h>

/** Form factor from a surface element to a parallel rectangle a by b over one of its corners, at
 * distance c (catalog B-3). */
static inline double form_factor_parallel(double a, double b, double c)
{
    const double x = a / c;
    const double y = b / c;
    const double p = sqrt(1.0 + x * x);
    const double q = sqrt(1.0 + y * y);
    return (x / p * atan(y / p) + y / q * atan(x / q)) / (2.0 * 3.14159265358979323846);
}

/** Form factor from a surface element to a rectangle that stands upright before it: b wide to one
 * side from where it is nearest, at distance c, a high from the element's own level (catalog B-4).
 */
static inline double form_factor_upright(double a, double b, double c)
{
    const double x = a / b;
    const double y = c / b;
    const double r = sqrt(x * x + y * y);
    return (atan(1.0 / y) - y / r * atan(1.0 / r)) / (2.0 * 3.14159265358979323846);
}

#endif
