// Public header of render: the Renderer, its options and the settings of a strategy.
#pragma once

#include "equaltime/render/renderer.h"
#include "equaltime/transport/settings.h"
