/* The C interface in C99: the header needs nothing else, its layout is the documented one, and a C program links. */
#include <handhold/handhold.h>
#include <stdio.h>
#include <string.h>

static int failed = 0;

static void expect(int right, const char* what) {
  if (right) return;
  ++failed;
  printf("not so: %s\n", what);
}
#define EXPECT(condition) expect((condition) != 0, #condition)

/* These numbers are promised (engine/EMBEDDING.md). A field may be added at the end of a struct: add a line for it and
   raise the size; no other line may ever change while HANDHOLD_ABI stays 1. Pointers of 8 bytes. */
static void check_layout(void) {
  EXPECT(sizeof(handhold_code) == 4 && sizeof(handhold_status) == 4);

  EXPECT(offsetof(handhold_cloud, data) == 0);
  EXPECT(offsetof(handhold_cloud, width) == 8);
  EXPECT(offsetof(handhold_cloud, height) == 12);
  EXPECT(offsetof(handhold_cloud, point_step) == 16);
  EXPECT(offsetof(handhold_cloud, no_viewpoint) == 20);
  EXPECT(offsetof(handhold_cloud, viewpoint) == 24);
  EXPECT(sizeof(handhold_cloud) == 48);

  EXPECT(offsetof(handhold_frame, status) == 0);
  EXPECT(offsetof(handhold_frame, handles) == 4);
  EXPECT(offsetof(handhold_frame, affordances) == 8);
  EXPECT(offsetof(handhold_frame, points) == 16);
  EXPECT(offsetof(handhold_frame, finite_points) == 24);
  EXPECT(sizeof(handhold_frame) == 32);

  EXPECT(offsetof(handhold_handle, center) == 0);
  EXPECT(offsetof(handhold_handle, axis) == 24);
  EXPECT(offsetof(handhold_handle, approach) == 48);
  EXPECT(offsetof(handhold_handle, radius) == 72);
  EXPECT(offsetof(handhold_handle, length) == 80);
  EXPECT(offsetof(handhold_handle, confidence) == 88);
  EXPECT(offsetof(handhold_handle, arc) == 96);
  EXPECT(offsetof(handhold_handle, residual) == 104);
  EXPECT(offsetof(handhold_handle, observed_free) == 112);
  EXPECT(offsetof(handhold_handle, normal_error) == 120);
  EXPECT(offsetof(handhold_handle, path) == 128);
  EXPECT(offsetof(handhold_handle, affordances) == 136);
  EXPECT(offsetof(handhold_handle, path_points) == 144);
  EXPECT(offsetof(handhold_handle, affordance_count) == 148);
  EXPECT(sizeof(handhold_handle) == 152);

  EXPECT(offsetof(handhold_affordance, center) == 0);
  EXPECT(offsetof(handhold_affordance, axis) == 24);
  EXPECT(offsetof(handhold_affordance, normal) == 48);
  EXPECT(offsetof(handhold_affordance, radius) == 72);
  EXPECT(offsetof(handhold_affordance, shell_radius) == 80);
  EXPECT(offsetof(handhold_affordance, gap) == 88);
  EXPECT(offsetof(handhold_affordance, curvature) == 96);
  EXPECT(offsetof(handhold_affordance, observed_free) == 104);
  EXPECT(offsetof(handhold_affordance, quality) == 112);
  EXPECT(offsetof(handhold_affordance, neighbourhood) == 120);
  EXPECT(offsetof(handhold_affordance, sample) == 128);
  EXPECT(sizeof(handhold_affordance) == 136);

  EXPECT(offsetof(handhold_funnel, samples) == 0);
  EXPECT(offsetof(handhold_funnel, too_few_points) == 8);
  EXPECT(offsetof(handhold_funnel, flat) == 16);
  EXPECT(offsetof(handhold_funnel, curvature_low) == 24);
  EXPECT(offsetof(handhold_funnel, concave) == 32);
  EXPECT(offsetof(handhold_funnel, circle_wide) == 40);
  EXPECT(offsetof(handhold_funnel, circle_narrow) == 48);
  EXPECT(offsetof(handhold_funnel, poor_fit) == 56);
  EXPECT(offsetof(handhold_funnel, no_gap) == 64);
  EXPECT(offsetof(handhold_funnel, shell_empty) == 72);
  EXPECT(offsetof(handhold_funnel, affordances) == 80);
  EXPECT(offsetof(handhold_funnel, cut) == 88);
  EXPECT(offsetof(handhold_funnel, not_aligned) == 96);
  EXPECT(offsetof(handhold_funnel, unconfirmed) == 104);
  EXPECT(offsetof(handhold_funnel, too_short) == 112);
  EXPECT(offsetof(handhold_funnel, low_confidence) == 120);
  EXPECT(offsetof(handhold_funnel, in_handles) == 128);
  EXPECT(sizeof(handhold_funnel) == 136);

  EXPECT(offsetof(handhold_times, index) == 0);
  EXPECT(offsetof(handhold_times, samples) == 8);
  EXPECT(offsetof(handhold_times, neighbours) == 16);
  EXPECT(offsetof(handhold_times, moments) == 24);
  EXPECT(offsetof(handhold_times, fit) == 32);
  EXPECT(offsetof(handhold_times, shell) == 40);
  EXPECT(offsetof(handhold_times, visibility) == 48);
  EXPECT(offsetof(handhold_times, handles) == 56);
  EXPECT(offsetof(handhold_times, total) == 64);
  EXPECT(sizeof(handhold_times) == 72);
}

int main(void) {
  handhold_localizer* localizer = NULL;
  handhold_cloud cloud;
  handhold_frame frame;
  if (sizeof(void*) == 8) check_layout();
  memset(&cloud, 0, sizeof cloud);
  EXPECT(handhold_abi() == HANDHOLD_ABI);
  EXPECT(strcmp(handhold_version(), HANDHOLD_VERSION_STRING) == 0);
  EXPECT(handhold_localizer_create(NULL, &localizer) == HANDHOLD_OK);
  EXPECT(handhold_localize(localizer, &cloud, sizeof cloud) == HANDHOLD_OK);
  EXPECT(handhold_get_frame(localizer, &frame, sizeof frame) == HANDHOLD_OK);
  EXPECT(frame.status == HANDHOLD_STATUS_EMPTY);
  EXPECT(strcmp(handhold_localizer_backend(localizer), "cpu") == 0);
  EXPECT(strcmp(handhold_localizer_backend_reason(localizer), "") == 0);
  handhold_localizer_destroy(localizer);
  return failed ? 1 : 0;
}
