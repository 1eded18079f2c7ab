/* Starts a C program on one of QEMU's mps2 boards: variables, floating point, and files of the host by semihosting. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

extern uint32_t data_start, data_end, data_load, bss_start, bss_end, stack_top;
extern void initialise_monitor_handles(void);
extern int main(int count_of_words, char **words);
void reset(void);

static void fault(void) {
    exit(3);
}

void reset(void) {
#ifdef __ARM_FP
    /* CPACR: full access to the floating-point unit. */
    *(volatile uint32_t *)0xE000ED88 |= 0xFu << 20;
    __asm volatile("dsb\n isb");
#endif
    memcpy(&data_start, &data_load, (size_t)((char *)&data_end - (char *)&data_start));
    memset(&bss_start, 0, (size_t)((char *)&bss_end - (char *)&bss_start));
    initialise_monitor_handles();
    exit(main(0, NULL));
}

__attribute__((section(".vectors"), used)) static const void *const vectors[] = {
    &stack_top, (const void *)reset, (const void *)fault, (const void *)fault,
    (const void *)fault, (const void *)fault, (const void *)fault,
};

/* What the C library asks of a start of its own kind. */
void _init(void) {}
void _fini(void) {}
