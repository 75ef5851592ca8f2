// Eight floats that are worked on at once: the loops over pixels are written in them, and the
// compiler makes what the processor has of them (two halves without AVX). No fused multiply-add:
// the same bytes on every processor.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>

namespace cwm::perception {

inline constexpr int kLanes = 8;  // cited: of an AVX register, 32 bytes

using Lanes = float __attribute__((vector_size(kLanes * sizeof(float))));
// All bits of a lane set: yes. Comparisons of Lanes give it.
using LaneMask = std::int32_t __attribute__((vector_size(kLanes * sizeof(float))));

// Functions on lanes are parts of the loops that use them, compiled for the processor of the loop.
#define CWM_LANES_INLINE inline __attribute__((always_inline))

// Whether the processor has AVX2, and loops compiled for it may run.
inline bool HasWideLanes() {
#if defined(__x86_64__)
  static const bool has = __builtin_cpu_supports("avx2") != 0;
  return has;
#else
  return false;
#endif
}

CWM_LANES_INLINE Lanes LoadLanes(const float* from) {
  Lanes v;
  std::memcpy(&v, from, sizeof(v));
  return v;
}

CWM_LANES_INLINE void StoreLanes(const Lanes& v, float* to) { std::memcpy(to, &v, sizeof(v)); }

// The value where the mask says yes, else 0.
CWM_LANES_INLINE Lanes Where(const LaneMask& mask, const Lanes& v) {
  return reinterpret_cast<Lanes>(mask & reinterpret_cast<LaneMask>(v));
}

CWM_LANES_INLINE Lanes Greater(const Lanes& a, const Lanes& b) {
  const LaneMask first = a > b;
  return Where(first, a) + Where(~first, b);
}

CWM_LANES_INLINE Lanes Lesser(const Lanes& a, const Lanes& b) {
  const LaneMask first = a < b;
  return Where(first, a) + Where(~first, b);
}

CWM_LANES_INLINE Lanes Absolute(const Lanes& v) {
  return reinterpret_cast<Lanes>(reinterpret_cast<LaneMask>(v) & 0x7fffffff);
}

CWM_LANES_INLINE Lanes SquareRoots(const Lanes& v) {
  Lanes roots;
  for (int lane = 0; lane < kLanes; ++lane) roots[lane] = std::sqrt(v[lane]);
  return roots;
}

// Of positive numbers, to some roundings: two steps of Newton's from a guess by the exponent, a third
// of which is the root's.
CWM_LANES_INLINE Lanes CubeRoots(const Lanes& v) {
  // cited: two thirds of the exponent's bias of 127, in its place, less what makes the guess err
  // equally to both sides (W. Kahan, as in the C library of FreeBSD).
  constexpr float kThirdOfBias = 709958130.0f;
  const Lanes bits = __builtin_convertvector(reinterpret_cast<LaneMask>(v), Lanes);
  Lanes root =
      reinterpret_cast<Lanes>(__builtin_convertvector(bits / 3.0f + kThirdOfBias, LaneMask));
  for (int i = 0; i < 2; ++i) root = (2.0f * root + v / (root * root)) / 3.0f;
  return root;
}

}  // namespace cwm::perception
