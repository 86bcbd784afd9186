/* What plain.c may need. */
double helper(double u) { return 2 * u; }
