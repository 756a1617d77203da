// Public header of io: readers of OBJ and PLY, and the mesh that they return.
#pragma once

#include "equaltime/io/mesh_data.h"
#include "equaltime/io/obj.h"
#include "equaltime/io/ply.h"
