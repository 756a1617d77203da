// Public header of analysis: what can be asked about a scene, a render or one sample.
#pragma once

#include "equaltime/analysis/alpha.h"
#include "equaltime/analysis/error_parts.h"
#include "equaltime/analysis/light_breakdown.h"
#include "equaltime/analysis/limit.h"
#include "equaltime/analysis/replay.h"
#include "equaltime/analysis/specular.h"
#include "equaltime/analysis/unoccluded_light.h"
#include "equaltime/analysis/visible_emitters.h"
