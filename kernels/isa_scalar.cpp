#define HANDHOLD_ISA_SCALAR
#define HANDHOLD_ISA_NAME "scalar"
#define HANDHOLD_LANE lane_scalar
#include "kernels.inc"
