/* math/unit.h - quantities written with a unit: "4 cm", "9.81 m/s^2", "30 deg".
 *
 * Grammar:  quantity = number [unit]
 *           unit     = factor { ("*" | "." | " ") factor | "/" factor }       left to right, so "J/kg K" is J K/kg
 *           factor   = symbol [ ["^"] integer ] | "(" unit ")" [ ["^"] integer ] | "1"
 * A symbol is a unit with or without an SI prefix. Where a symbol can be read both ways the plain unit wins: "min" is a minute.
 * "degC" stands alone only. dig_unit_parse of digbox.h is implemented here.
 *
 * Floor: math.
 */
#ifndef DIG_UNIT_H
#define DIG_UNIT_H

#include "base/base.h"

typedef struct Dimension {
    int m, kg, s, A, K, rad;        /* exponents */
} Dimension;

/* Reads a unit such as "N*m/rad". *scale is its size in SI. DIG_E_FORMAT when it is none; bad then holds the part that is not
 * understood. */
dig_status unit_read(const char *text, Dimension *dimension, real *scale, char *bad, size_t capacity);

/* "a length", "a mass", ..., or NULL for a dimension without a common name. hint: the unit as written; it tells "J" from "N m". */
const char *unit_dimension_name(Dimension d, const char *hint);

#endif
