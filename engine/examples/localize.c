/* Finds what can be held in a frame, in C. The frame is made up: a rod before the sensor. With CMake:
     find_package(handhold REQUIRED)
     target_link_libraries(your_program PRIVATE handhold::c)
   Without: gcc -std=c99 localize.c $(pkg-config --cflags --libs handhold_c) -lm */
#include <handhold/handhold.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static float points[150 * 71][3]; /* x, y, z in metres; the sensor stands in the origin and looks along z */

static void stop(const char* message) {
  fprintf(stderr, "localize: %s\n", message);
  exit(1);
}

int main(void) {
  for (int i = 0; i < 150 * 71; ++i) {
    const double angle = 0.04 * (i % 71 - 35);
    points[i][0] = (float)(0.025 * sin(angle));
    points[i][1] = (float)(0.002 * (i / 71) - 0.15);
    points[i][2] = (float)(0.7 - 0.025 * cos(angle));
  }
  const handhold_cloud cloud = {.data = points[0], .width = 150 * 71, .height = 1};

  handhold_options* options = NULL;
  handhold_localizer* localizer = NULL;
  if (handhold_options_create(&options) || handhold_set(options, "hand_aperture", "0.1") /* m */ ||
      handhold_localizer_create(options, &localizer)) /* once */
    stop(handhold_options_message(options));
  if (handhold_localize(localizer, &cloud, sizeof cloud)) /* for each frame */
    stop(handhold_localizer_message(localizer));

  handhold_frame frame;
  handhold_get_frame(localizer, &frame, sizeof frame);
  printf("status %s\n", handhold_status_text(frame.status));
  for (uint32_t i = 0; i < frame.handles; ++i) {
    handhold_handle h;
    handhold_get_handles(localizer, i, 1, &h, sizeof h);
    printf("handle at %.3f %.3f %.3f m, axis %.2f %.2f %.2f, radius %.3f m, confidence %.2f\n", h.center[0],
           h.center[1], h.center[2], h.axis[0], h.axis[1], h.axis[2], h.radius, h.confidence);
  }
  handhold_localizer_destroy(localizer);
  handhold_options_destroy(options);
  return frame.handles == 0;
}
