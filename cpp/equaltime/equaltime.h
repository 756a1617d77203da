// The public headers of all rooms: to describe, build, render and analyse a scene, and to read meshes.
// cpp/README.md says which names are public and what is thread-safe. No file of the core includes this one.
#pragma once

#include "equaltime/analysis/analysis.h"
#include "equaltime/build/build.h"
#include "equaltime/film/film.h"
#include "equaltime/io/io.h"
#include "equaltime/render/render.h"
