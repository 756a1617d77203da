// Embree 3.13 or 4, whichever CMake found, and the two calls that differ between them.
#pragma once

#if EQUALTIME_EMBREE == 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace equaltime {

/// Puts what the ray meets into the query, if that is nearer than its tfar.
inline void embree_intersect(RTCScene scene, RTCRayHit& query) noexcept {
#if EQUALTIME_EMBREE == 4
  rtcIntersect1(scene, &query);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene, &context, &query);
#endif
}

/// Puts what each valid lane of a packet meets into the query.
inline void embree_intersect(const int* valid, RTCScene scene, RTCRayHit8& query) noexcept {
#if EQUALTIME_EMBREE == 4
  rtcIntersect8(valid, scene, &query);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect8(valid, scene, &context, &query);
#endif
}

/// Makes the ray's tfar -infinity if it meets anything.
inline void embree_occluded(RTCScene scene, RTCRay& ray) noexcept {
#if EQUALTIME_EMBREE == 4
  rtcOccluded1(scene, &ray);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(scene, &context, &ray);
#endif
}

/// Makes tfar -infinity in each valid lane of a packet whose ray meets anything.
inline void embree_occluded(const int* valid, RTCScene scene, RTCRay8& rays) noexcept {
#if EQUALTIME_EMBREE == 4
  rtcOccluded8(valid, scene, &rays);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded8(valid, scene, &context, &rays);
#endif
}

}  // namespace equaltime
