// Absorption over a step, exact for small and large optical depths.

// Light removed by a step of optical depth `dtau`: T_before - T_after, without cancellation where the
// step is thin. Below 0.03 three terms of T_before (1 - exp(-dtau)) are exact to 1e-6; above it the
// difference is.
float absorbed(float t_before, float t_after, float dtau) {
    float series = t_before * dtau * (1.0 - dtau * (0.5 - dtau * (1.0 / 6.0)));
    return dtau < 0.03 ? series : t_before - t_after;
}

// Mean of exp(-tau) from `before` to `after`, over which tau rises evenly by `rise`.
float mean_between(float before, float after, float rise) {
    return abs(rise) < 0.03 ? before * (1.0 - rise * (0.5 - rise * (1.0 / 6.0))) : (before - after) / rise;
}
