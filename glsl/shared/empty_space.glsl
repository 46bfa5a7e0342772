// Leaping the cells that the transfer function leaves empty.

// A ray in cells: where its first sample lies and how it crosses them.
struct CellRay {
    vec3 first;
    vec3 per_step;
    vec3 steps_per_cell; // signed; huge along axes it does not cross
    vec3 ahead;          // 1 where cells rise along the ray, else 0
};

// p_first, dp: first sample and step in texture coordinates, of which one unit is `cells` cells.
CellRay cell_ray(vec3 p_first, vec3 dp, vec3 cells) {
    CellRay ray;
    ray.first = p_first * cells;
    ray.per_step = dp * cells;
    // No cell is crossed in less than 1e-6 of a step or more than 1e6 steps.
    vec3 crossing = max(abs(ray.per_step), 1e-6);
    ray.ahead = step(vec3(0.0), ray.per_step);
    ray.steps_per_cell = mix(-1.0 / crossing, 1.0 / crossing, ray.ahead);
    return ray;
}

// Steps from sample i that stay inside empty cells (at least 1), 0 in an occupied cell; last: the
// largest grid coordinate.
int empty_steps(CellRay ray, float i, vec3 last) {
    vec3 at = clamp(ray.first + i * ray.per_step, vec3(0.0), last);
    ivec3 cell = ivec3(at);
    float reach = float(distance_at(cell));
    // All cells closer than `reach` are empty: leave their cube. Per axis its face lies
    // reach - 1 cells beyond the near face of this one.
    vec3 to_face = (ray.ahead - (at - vec3(cell))) * ray.steps_per_cell;
    vec3 steps = to_face + (reach - 1.0) * abs(ray.steps_per_cell);
    float nearest = min(min(steps.x, steps.y), min(steps.z, 1e6));
    return reach == 0.0 ? 0 : max(1, int(ceil(nearest)));
}
