// The method in plain double precision, a file per step. Written to be read and to be compared with, not to be fast: no
// step shares code with the kernels. Steps whose own rounding matters are templates, so that long double can judge
// double.
#pragma once

#include "reference/align.h"
#include "reference/circle.h"
#include "reference/curvature.h"
#include "reference/fingers.h"
#include "reference/moments.h"
#include "reference/neighbours.h"
#include "reference/normals.h"
#include "reference/pipeline.h"
#include "reference/shell.h"
#include "reference/taubin.h"
