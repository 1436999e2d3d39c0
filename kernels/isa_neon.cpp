#define HANDHOLD_ISA_NEON
#define HANDHOLD_ISA_NAME "neon"
#define HANDHOLD_LANE lane_neon
#include "kernels.inc"
