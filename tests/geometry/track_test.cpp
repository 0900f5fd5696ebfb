// Following surfaces of which every frame has other faces.
#include "decimate_fixture.h"

#include "fvv_cxx/error.h"
#include "fvv_geometry/marching_cubes.h"
#include "fvv_geometry/pieces.h"
