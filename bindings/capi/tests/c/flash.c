/* The loop of docs/c.md as a whole program, so that its flash can be measured; without a filter what a program takes without the library. */
#include <scphd.h>

float speed_mps, rate_radps, dt_s, x_m, y_m;
scphd_range_bearing scan[32];
size_t count;

void drive(void);
void wait_for_scan(void);

void wait_for_scan(void) {}

int main(void) {
#ifdef WITH_FILTER
    drive();
#endif
    return 0;
}
