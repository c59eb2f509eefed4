#pragma once

// Four floats at once. SSE2 belongs to every x86-64; elsewhere the same operations run one by one, with the
// same results but for roughReciprocal().
//
// 1. Float4::load(), Float4::store() and signedBytes() want addresses that are multiples of 16, and so do
// unpackSlabs() and slabOfNode(), which are made of them.

#include <cmath>
#include <cstdint>

#include <glm/vec3.hpp>

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
inline Float4 operator/(Float4 a, Float4 b) { return Float4(_mm_div_ps(a.v, b.v)); }
inline Float4 min(Float4 a, Float4 b) { return Float4(_mm_min_ps(a.v, b.v)); }
inline Float4 max(Float4 a, Float4 b) { return Float4(_mm_max_ps(a.v, b.v)); }
inline Float4 sqrt(Float4 a) { return Float4(_mm_sqrt_ps(a.v)); }
inline Float4 abs(Float4 a) { return Float4(_mm_andnot_ps(_mm_set1_ps(-0.0f), a.v)); }
/// 1 / a, off by a share of up to 2^-11; what depends on it may differ from machine to machine.
inline Float4 roughReciprocal(Float4 a) { return Float4(_mm_rcp_ps(a.v)); }
/// Bit i is set where a[i] <= b[i]; not where either is NaN.
inline int lessEqualMask(Float4 a, Float4 b) { return _mm_movemask_ps(_mm_cmple_ps(a.v, b.v)); }
inline int lessMask(Float4 a, Float4 b) { return _mm_movemask_ps(_mm_cmplt_ps(a.v, b.v)); }
/// Lane i of `yes` where a[i] <= b[i], else of `no`.
inline Float4 selectLessEqual(Float4 a, Float4 b, Float4 yes, Float4 no) {
  const __m128 mask = _mm_cmple_ps(a.v, b.v);
  return Float4(_mm_or_ps(_mm_and_ps(mask, yes.v), _mm_andnot_ps(mask, no.v)));
}
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
inline Float4 operator/(Float4 a, Float4 b) {
  return forEach(a, b, [](float x, float y) { return x / y; });
}
inline Float4 min(Float4 a, Float4 b) {
  return forEach(a, b, [](float x, float y) { return x < y ? x : y; });
}
inline Float4 max(Float4 a, Float4 b) {
  return forEach(a, b, [](float x, float y) { return x > y ? x : y; });
}
inline Float4 sqrt(Float4 a) {
  return forEach(a, a, [](float x, float) { return std::sqrt(x); });
}
inline Float4 abs(Float4 a) {
  return forEach(a, a, [](float x, float) { return std::abs(x); });
}
inline Float4 roughReciprocal(Float4 a) { return Float4(1.0f) / a; }
inline int lessEqualMask(Float4 a, Float4 b) {
  int mask = 0;
  for (int i = 0; i < 4; ++i) mask |= (a.v[i] <= b.v[i] ? 1 : 0) << i;
  return mask;
}
inline int lessMask(Float4 a, Float4 b) {
  int mask = 0;
  for (int i = 0; i < 4; ++i) mask |= (a.v[i] < b.v[i] ? 1 : 0) << i;
  return mask;
}
inline Float4 selectLessEqual(Float4 a, Float4 b, Float4 yes, Float4 no) {
  Float4 r;
  for (int i = 0; i < 4; ++i) r.v[i] = a.v[i] <= b.v[i] ? yes.v[i] : no.v[i];
  return r;
}
#endif

/// Four vectors side by side.
struct Vec4 {
  Float4 x, y, z;
};
inline Vec4 operator+(const Vec4& a, const Vec4& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec4 operator-(const Vec4& a, const Vec4& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec4 operator*(const Vec4& a, Float4 s) { return {a.x * s, a.y * s, a.z * s}; }
inline Vec4 min(const Vec4& a, const Vec4& b) { return {min(a.x, b.x), min(a.y, b.y), min(a.z, b.z)}; }
inline Vec4 max(const Vec4& a, const Vec4& b) { return {max(a.x, b.x), max(a.y, b.y), max(a.z, b.z)}; }
inline Vec4 abs(const Vec4& a) { return {abs(a.x), abs(a.y), abs(a.z)}; }
inline Float4 dot(const Vec4& a, const Vec4& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec4 cross(const Vec4& a, const Vec4& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Vec4 selectLessEqual(Float4 a, Float4 b, const Vec4& yes, const Vec4& no) {
  return {selectLessEqual(a, b, yes.x, no.x), selectLessEqual(a, b, yes.y, no.y),
          selectLessEqual(a, b, yes.z, no.z)};
}

/// The least lane of each component: x, y, z, and z again.
inline Float4 leastLanes(const Vec4& v) {
#if defined(__SSE2__)
  __m128 row[4] = {v.x.v, v.y.v, v.z.v, v.z.v};
  _MM_TRANSPOSE4_PS(row[0], row[1], row[2], row[3]);
  return Float4(_mm_min_ps(_mm_min_ps(row[0], row[1]), _mm_min_ps(row[2], row[3])));
#else
  const auto least = [](Float4 f) {
    const float a = f.v[0] < f.v[1] ? f.v[0] : f.v[1], b = f.v[2] < f.v[3] ? f.v[2] : f.v[3];
    return a < b ? a : b;
  };
  Float4 r;
  r.v[0] = least(v.x);
  r.v[1] = least(v.y);
  r.v[2] = r.v[3] = least(v.z);
  return r;
#endif
}

/// Byte `index` (0 lowest) of four words, as signed numbers.
inline Float4 signedBytes(const std::uint32_t* words, int index) {
#if defined(__SSE2__)
  const __m128i w = _mm_load_si128(reinterpret_cast<const __m128i*>(words));
  return Float4(_mm_cvtepi32_ps(_mm_srai_epi32(_mm_slli_epi32(w, 24 - 8 * index), 24)));
#else
  Float4 r;
  for (int i = 0; i < 4; ++i) r.v[i] = static_cast<std::int8_t>(words[i] >> (8 * index));
  return r;
#endif
}

/// Four points relative to `origin`: the differences are taken in double, then rounded.
inline Vec4 gatherRelative(const glm::dvec3* const points[4], const glm::dvec3& origin) {
#if defined(__SSE2__)
  const __m128d oxy = _mm_loadu_pd(&origin.x);
  const __m128d oz = _mm_load_sd(&origin.z);
  __m128 row[4];
  for (int i = 0; i < 4; ++i) {
    const __m128 xy = _mm_cvtpd_ps(_mm_sub_pd(_mm_loadu_pd(&points[i]->x), oxy));
    const __m128 z = _mm_cvtpd_ps(_mm_sub_sd(_mm_load_sd(&points[i]->z), oz));
    row[i] = _mm_movelh_ps(xy, z);
  }
  _MM_TRANSPOSE4_PS(row[0], row[1], row[2], row[3]);
  return {Float4(row[0]), Float4(row[1]), Float4(row[2])};
#else
  Vec4 r;
  for (int i = 0; i < 4; ++i) {
    r.x.v[i] = static_cast<float>(points[i]->x - origin.x);
    r.y.v[i] = static_cast<float>(points[i]->y - origin.y);
    r.z.v[i] = static_cast<float>(points[i]->z - origin.z);
  }
  return r;
#endif
}

}  // namespace tandem::haptics
