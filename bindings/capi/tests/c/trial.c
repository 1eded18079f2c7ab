/* Whether a compiler has all that a board's program needs: output, files, mathematics, memory. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int main(int count_of_words, char **words) {
    FILE *file = fopen(count_of_words > 1 ? words[1] : "trial", "r");
    char line[16];
    memset(line, 0, sizeof line);
    if (file == NULL || fgets(line, sizeof line, file) == NULL) return EXIT_FAILURE;
    printf("%f\n", sqrt(strtod(line, NULL)));
    return fclose(file);
}
