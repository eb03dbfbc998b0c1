/* tests/check.h - checks on top of cmocka that print file, line, got, want and tolerance.
 *
 *   TEST(two_bodies_relax) { CHECK_NEAR(t, 350, 1e-9); }
 *   int main(void) { RUN_TESTS(unit_test(two_bodies_relax)); }
 */
#ifndef DIG_CHECK_H
#define DIG_CHECK_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#define TEST(name) static void name(void **check_state_ __attribute__((unused)))
#undef unit_test                                       /* cmocka has a deprecated macro of that name */
#define unit_test(name) cmocka_unit_test(name)

#define CHECK(condition)                                                                        \
    do {                                                                                        \
        if (!(condition))                                                                       \
            fail_msg("%s:%d: %s does not hold", __FILE__, __LINE__, #condition);                \
    } while (0)

/* Written so that NaN fails. */
#define CHECK_NEAR(got, want, tolerance)                                                        \
    do {                                                                                        \
        double got_ = (double)(got), want_ = (double)(want), tolerance_ = (double)(tolerance);  \
        if (!(fabs(got_ - want_) <= tolerance_))                                                \
            fail_msg("%s:%d: %s = %.17g, want %.17g +- %g (off by %g)", __FILE__, __LINE__,     \
                     #got, got_, want_, tolerance_, got_ - want_);                              \
    } while (0)

#define CHECK_INT(got, want)                                                                    \
    do {                                                                                        \
        long long got_ = (long long)(got), want_ = (long long)(want);                           \
        if (got_ != want_)                                                                      \
            fail_msg("%s:%d: %s = %lld, want %lld", __FILE__, __LINE__, #got, got_, want_);     \
    } while (0)

#define CHECK_TEXT(got, want)                                                                   \
    do {                                                                                        \
        const char *got_ = (got), *want_ = (want);                                              \
        if (!got_ || strcmp(got_, want_) != 0)                                                  \
            fail_msg("%s:%d: %s = \"%s\", want \"%s\"", __FILE__, __LINE__, #got, got_ ? got_ : "(null)", want_); \
    } while (0)

#define RUN_TESTS(...)                                                                          \
    const struct CMUnitTest check_tests_[] = {__VA_ARGS__};                                     \
    return cmocka_run_group_tests(check_tests_, NULL, NULL)

#endif
