#pragma once

// Four floats at once. SSE2 belongs to every x86-64; elsewhere the same operations run one by one, with the
// same results.

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace tandem::haptics {

#if defined(__SSE2__)
struct Float4 {
  __m128 v;
  Float4() : v(_mm_setzero_ps()) {}
  explicit Float4(__m128 x) : v(x) {}
  explicit Float4(float x) : v(_mm_set1_ps(x)) {}
  static Float4 load(const float* p) { return Float4(_mm_load_ps(p)); }
  void store(float* p) const { _mm_store_ps(p, v); }
};
inline Float4 operator+(Float4 a, Float4 b) { return Float4(_mm_add_ps(a.v, b.v)); }
inline Float4 operator-(Float4 a, Float4 b) { return Float4(_mm_sub_ps(a.v, b.v)); }
inline Float4 operator*(Float4 a, Float4 b) { return Float4(_mm_mul_ps(a.v, b.v)); }
inline Float4 min(Float4 a, Float4 b) { return Float4(_mm_min_ps(a.v, b.v)); }
inline Float4 max(Float4 a, Float4 b) { return Float4(_mm_max_ps(a.v, b.v)); }
/// Bit i is set where a[i] <= b[i].
inline int lessEqualMask(Float4 a, Float4 b) { return _mm_movemask_ps(_mm_cmple_ps(a.v, b.v)); }
#else
struct Float4 {
  float v[4];
  Float4() : v{0.0f, 0.0f, 0.0f, 0.0f} {}
  explicit Float4(float x) : v{x, x, x, x} {}
  static Float4 load(const float* p) {
    Float4 r;
    for (int i = 0; i < 4; ++i) r.v[i] = p[i];
    return r;
  }
  void store(float* p) const {
    for (int i = 0; i < 4; ++i) p[i] = v[i];
  }
};
template <typename Operation>
inline Float4 forEach(Float4 a, Float4 b, Operation operation) {
  Float4 r;
  for (int i = 0; i < 4; ++i) r.v[i] = operation(a.v[i], b.v[i]);
  return r;
}
inline Float4 operator+(Float4 a, Float4 b) {
  return forEach(a, b, [](float x, float y) { return x + y; });
}
inline Float4 operator-(Float4 a, Float4 b) {
  return forEach(a, b, [](float x, float y) { return x - y; });
}
inline Float4 operator*(Float4 a, Float4 b) {
  return forEach(a, b, [](float x, float y) { return x * y; });
}
inline Float4 min(Float4 a, Float4 b) {
  return forEach(a, b, [](float x, float y) { return x < y ? x : y; });
}
inline Float4 max(Float4 a, Float4 b) {
  return forEach(a, b, [](float x, float y) { return x > y ? x : y; });
}
inline int lessEqualMask(Float4 a, Float4 b) {
  int mask = 0;
  for (int i = 0; i < 4; ++i) mask |= (a.v[i] <= b.v[i] ? 1 : 0) << i;
  return mask;
}
#endif

}  // namespace tandem::haptics
