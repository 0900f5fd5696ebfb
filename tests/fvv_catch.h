/* Catch2 2 (Debian 12) and 3 (later) alike. */
#ifndef FVV_TESTS_CATCH_H
#define FVV_TESTS_CATCH_H

#if __has_include(<catch2/catch_all.hpp>)
#include <catch2/catch_all.hpp>
using Catch::Approx;
#else
#include <catch2/catch.hpp>
#endif

#endif
