/* Checks that say where they failed. */
#ifndef CHECK_H
#define CHECK_H

#include <scphd.h>
#include <stdio.h>

static int failures = 0;

static inline void check_status(int got, int wanted, const char *what, int line) {
    if (got != wanted) {
        printf("line %d: %s: %s, not %s\n", line, what, scphd_error_text(got), scphd_error_text(wanted));
        failures++;
    }
}

static inline void check_true(int holds, const char *what, int line) {
    if (!holds) {
        printf("line %d: %s does not hold\n", line, what);
        failures++;
    }
}

#define IS(call, status) check_status((int)(call), (int)(status), #call, __LINE__)
#define OK(call) IS(call, SCPHD_STATUS_OK)
#define HOLDS(condition) check_true((condition), #condition, __LINE__)

#endif
