// Vectors of three coordinates, one a SIMD lane. Included by each file that is compiled once for every kind of SIMD,
// after highway.h. No product is fused with a sum, so that every kind gives the same bits.

#if defined(MUSCLEBENCH_VEC_LANES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef MUSCLEBENCH_VEC_LANES_INL
#undef MUSCLEBENCH_VEC_LANES_INL
#else
#define MUSCLEBENCH_VEC_LANES_INL
#endif

HWY_BEFORE_NAMESPACE();
namespace musclebench::HWY_NAMESPACE {  // NOLINT: Highway's macro
namespace {

template <typename Lane>
struct VecLanesOf {
  Lane x, y, z;
};

template <typename Lane>
HWY_INLINE VecLanesOf<Lane> operator-(const VecLanesOf<Lane>& a, const VecLanesOf<Lane>& b) {
  namespace hn = hwy::HWY_NAMESPACE;
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}

template <typename Lane>
HWY_INLINE VecLanesOf<Lane> operator+(const VecLanesOf<Lane>& a, const VecLanesOf<Lane>& b) {
  namespace hn = hwy::HWY_NAMESPACE;
  return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
}

template <typename Lane>
HWY_INLINE VecLanesOf<Lane> operator*(Lane factor, const VecLanesOf<Lane>& a) {
  namespace hn = hwy::HWY_NAMESPACE;
  return {hn::Mul(factor, a.x), hn::Mul(factor, a.y), hn::Mul(factor, a.z)};
}

/// In the order in which Eigen sums three products.
template <typename Lane>
HWY_INLINE Lane dot(const VecLanesOf<Lane>& a, const VecLanesOf<Lane>& b) {
  namespace hn = hwy::HWY_NAMESPACE;
  return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}

template <typename Lane>
HWY_INLINE VecLanesOf<Lane> cross(const VecLanesOf<Lane>& a, const VecLanesOf<Lane>& b) {
  namespace hn = hwy::HWY_NAMESPACE;
  return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)), hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
          hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}

}  // namespace
}  // namespace musclebench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
