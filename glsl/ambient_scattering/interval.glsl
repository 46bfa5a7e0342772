// Light along a camera ray, known where the ray looks at it: at both ends of an interval of samples.

// What the cache's nodes scatter towards the viewer, one block of them a look.
layout(set = 0, binding = 13) uniform sampler3D gathered_light;

struct Interval {
    vec3 here[LOOKS];
    vec3 ahead[LOOKS];
    int begin;
    int end;
};

// What the nodes about grid coordinates q have seen.
void look_up(vec3 q, out vec3 seen[LOOKS]) {
    vec3 per_texel = 1.0 / vec3(textureSize(gathered_light, 0));
    for (uint l = 0; l < LOOKS; ++l) seen[l] = textureLod(gathered_light, place_in_block(q, l, per_texel), 0.0).rgb;
}

// Brings the interval to sample i.
void take_looks(ViewRay ray, int i, bool lit, inout Interval interval) {
    int looks = !lit || i < interval.end ? 0 : i == interval.end ? 1 : 2;
    for (uint l = 0; l < LOOKS; ++l) interval.here[l] = looks == 1 ? interval.ahead[l] : interval.here[l];
    // A loop, not a branch: software drivers go through branches that no lane takes.
    for (int n = 2 - looks; n < 2; ++n) {
        float at = float(i + n * INTERVAL) - 0.5;
        vec3 q = ray.grid.first + at * ray.grid.per_step;
        vec3 seen[LOOKS];
        if (GATHERED) {
            look_up(q, seen);
        } else {
            look(ray.x_first + at * ray.dt * ray.direction, q, ray.direction, seen);
        }
        for (uint l = 0; l < LOOKS; ++l) {
            interval.here[l] = n == 0 ? seen[l] : interval.here[l];
            interval.ahead[l] = n == 1 ? seen[l] : interval.ahead[l];
        }
    }
    interval.begin = looks > 0 ? i : interval.begin;
    interval.end = looks > 0 ? i + INTERVAL : interval.end;
}

// Radiance that a block gathers where light goes from `first` to `last` over an interval of which the block begins
// at a share of `at`. Light fades in a medium: it goes exponentially, and with the block's own transmittance is
// integrated so; its hue goes straight.
vec3 between(Block block, float at, vec3 first, vec3 last) {
    const float STEEPEST = 4.0;
    float here = first.r + first.g + first.b, ahead = last.r + last.g + last.b;
    float most = max(max(here, ahead), 1e-30);
    // A steeper change is that at a shadow's edge.
    float low = most * exp(-STEEPEST);
    float rise = log(max(ahead, low) / max(here, low));
    vec3 hue = first / max(here, 1e-30), hue_ahead = last / max(ahead, 1e-30);
    hue = here > 0.0 ? hue : hue_ahead;
    hue_ahead = ahead > 0.0 ? hue_ahead : hue;
    float share = 1.0 / float(INTERVAL);
    float before = exp(at * rise - block.tau[0]);
    vec3 sum = vec3(0.0);
    for (int k = 0; k < BLOCK; ++k) {
        float middle = at + (float(k) + 0.5) * share;
        float after = exp((at + float(k + 1) * share) * rise - block.tau[k + 1]);
        float weight = block.dtau[k] * mean_between(before, after, block.dtau[k] - share * rise);
        // Light as printed is that of the sample's place.
        if (LITERAL_GATHER) weight = block.literal[k] * exp(middle * rise);
        sum += weight * block.albedo[k] * mix(hue, hue_ahead, middle);
        before = after;
    }
    return max(here, low) * sum;
}

// Radiance that a block gathers from all lights; those apart are weakened by their distance over the block.
vec3 gathered(Block block, ViewRay ray, int i, Interval interval) {
    vec3 first = interval.here[APART], last = interval.ahead[APART];
    float length_block = float(BLOCK) * ray.dt;
    vec3 middle = ray.x_first + (float(i) + 0.5 * float(BLOCK - 1)) * ray.dt * ray.direction;
    for (uint l = 0; l < APART; ++l) {
        Light light = lights[l];
        bool weakens = light.place.w > 0.0 && light.irradiance.w > 0.0;
        float falloff = weakens ? mean_falloff(light.place.xyz, middle, ray.direction, length_block) : 1.0;
        first += falloff * interval.here[l];
        last += falloff * interval.ahead[l];
    }
    return ambient.table.w * between(block, float(i - interval.begin) / float(INTERVAL), first, last);
}
