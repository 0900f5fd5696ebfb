// stb_rect_pack with the same result on every machine. Each source file that includes this has its own copy.
#pragma once

#include <algorithm>

// Rectangles of equal size keep their order with any qsort.
namespace {
template <class Item, class Compare> void sort_stably(Item *items, size_t count, Compare compare) {
  std::stable_sort(items, items + count, [&](const Item &a, const Item &b) { return compare(&a, &b) < 0; });
}
} // namespace
#define STBRP_SORT(items, count, size, compare) sort_stably(items, size_t(count), compare)
#define STBRP_STATIC
#define STB_RECT_PACK_IMPLEMENTATION
#include <stb/stb_rect_pack.h>
