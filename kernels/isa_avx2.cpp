#define HANDHOLD_ISA_AVX2
#define HANDHOLD_ISA_NAME "avx2"
#define HANDHOLD_LANE lane_avx2
#include "kernels.inc"
