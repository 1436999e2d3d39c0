#define HANDHOLD_ISA_AVX512
#define HANDHOLD_ISA_NAME "avx512"
#define HANDHOLD_LANE lane_avx512
#include "kernels.inc"
