#pragma once

/// Functions whose bits are the same on every CPU: the C library picks variants with and without fused multiply-add
/// when the program starts, which differ in the last bit. For what a simulation's state depends on; all others take
/// the C library's. Errors are in units in the last place (ulp).
namespace musclebench::portable {

/// e^x, x <= 706; at most 2 ulp.
double exp(double x);
/// base^exponent for base >= 0 and a finite exponent; 0^0 is 1. Errs by 3 ulp and exponent * ln(base) times 4 ulp.
double pow(double base, double exponent);
/// Of an angle in radians; at most 2.5e-16 beside the exact one to a million radians.
double sin(double angle_rad);
double cos(double angle_rad);

}  // namespace musclebench::portable
