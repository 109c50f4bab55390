#pragma once

/// This file holds all differences between Embree 3.13 and Embree 4.
#if PIERCE_EMBREE_MAJOR >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace pierce::embree {

#if PIERCE_EMBREE_MAJOR >= 4
using QueryContext = RTCRayQueryContext;

inline void init_context(QueryContext& context) { rtcInitRayQueryContext(&context); }

inline void intersect(RTCScene scene, QueryContext& context, RTCRayHit& ray) {
    RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.context = &context;
    arguments.flags = RTC_RAY_QUERY_FLAG_INCOHERENT;
    rtcIntersect1(scene, &ray, &arguments);
}
#else
using QueryContext = RTCIntersectContext;

inline void init_context(QueryContext& context) { rtcInitIntersectContext(&context); }

inline void intersect(RTCScene scene, QueryContext& context, RTCRayHit& ray) {
    rtcIntersect1(scene, &context, &ray);
}
#endif

}  // namespace pierce::embree
