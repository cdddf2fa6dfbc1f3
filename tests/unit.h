/* unit.h: cmocka, the headers of the C library that it needs or that tests use, and their main function. */
#ifndef TESTS_UNIT_H
#define TESTS_UNIT_H

#include <float.h>
#include <inttypes.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define HELPER static inline __attribute__((unused))

#define TEST(function) cmocka_unit_test(function)

/* The main function; begin and end: called before and after all tests, or NULL. */
#define RUN_TESTS_BETWEEN(begin, end, ...)                                                         \
  int main(void) {                                                                                 \
    const struct CMUnitTest tests[] = {__VA_ARGS__};                                               \
    return cmocka_run_group_tests(tests, begin, end);                                              \
  }
#define RUN_TESTS(...) RUN_TESTS_BETWEEN(NULL, NULL, __VA_ARGS__)

#endif
