// Coincident emitters. Where an emitter lies in a surface to within rounding, Embree meets either of the two, and each
// technique would make another image. The rule is that the emitter is before the surface, on the side to which it
// emits, and of two emitters the one described later: it is moved there by a few millionths of the scene, when that is
// built.
#pragma once

#include "equaltime/build/description.h"
#include "equaltime/math/normalization.h"

namespace equaltime {

/// Moves the emitters of a description: flat ones, and spheres and cylinders that stand still and are one with another.
/// Moving shapes are compared at the first and the last key of their motion.
/// Throws std::invalid_argument that names the shape where one mesh emits twice from one place.
void bring_emitters_forward(SceneDescription& description, const Normalization& space);

}  // namespace equaltime
