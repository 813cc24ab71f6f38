// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Hot loops compiled for several generations of processor; the program takes the best when it
// starts. Debian's amd64 alone means neither popcount nor vectors of 32 bytes.
// Where they calculate with fractions their files are compiled with -ffp-contract=off, so that all
// give the same.
#pragma once

#include <cstddef>  // tells which C library this is

// The sanitizers are not ready yet when the choice is made.
#if defined(__x86_64__) && defined(__GLIBC__) && !defined(__clang__) && __GNUC__ >= 12 && \
    !defined(__SANITIZE_THREAD__) && !defined(__SANITIZE_ADDRESS__)
#define NADIR_CLONES [[gnu::target_clones("arch=x86-64-v3", "default")]]
#else
#define NADIR_CLONES
#endif
