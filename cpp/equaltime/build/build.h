// Public header of build: the description of a scene, its checks, and build_scene.
#pragma once

#include "equaltime/build/build_scene.h"
#include "equaltime/build/check_description.h"
#include "equaltime/build/description.h"
