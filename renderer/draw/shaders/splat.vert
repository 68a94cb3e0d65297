#version 330 core
// One quad a splat, along the eigenvectors of its image covariance, just wide enough for alpha >= 1/255.
// Positions are in pixels with y down: row 0 of the target is the top row of the picture.

const float LOW_PASS = 0.3;      // px^2
const float MARGIN = 0.02;       // px; covers the snapping of corners to the sub-pixel grid
const float LARGEST = 1e12;      // scene units; flat over any picture, and its square still a float

uniform sampler2D records;       // four texels a splat: mean opacity | quat wxyz | scales - | color -
uniform int splats_per_row;
uniform mat3 rotation;           // camera_from_world
uniform vec3 translation;
uniform vec4 lens;               // fx fy cx cy
uniform vec4 slopes;             // least x/z, y/z and greatest x/z, y/z that the Jacobian follows
uniform vec2 size;               // width height
uniform bool depth_as_color;
uniform bool compensated;        // opacity makes up for the low-pass

in uint splat;

flat out vec2 center;            // px
flat out vec3 shape;             // of the covariance (a b; b c): b / a, 1 / a, a / determinant
flat out vec4 paint;             // rgb, opacity

mat3 rotation_from(vec4 quat) {
    vec4 magnitude = abs(quat);
    float largest = max(max(magnitude.x, magnitude.y), max(magnitude.z, magnitude.w));
    vec4 q = largest > 0.0 ? normalize(quat / largest) : vec4(1.0, 0.0, 0.0, 0.0);
    float w = q.x, x = q.y, y = q.z, z = q.w;
    return mat3(
        1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y),
        2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x),
        2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y));
}

// Half axes of the ellipse of `reach` standard deviations of (a b; b c), longest first.
mat2 half_axes(float a, float b, float c, float determinant, float reach) {
    float half_difference = 0.5 * (a - c);
    float spread = length(vec2(half_difference, b));
    float longest = 0.5 * (a + c) + spread;
    vec2 along = half_difference >= 0.0 ? vec2(half_difference + spread, b) : vec2(b, spread - half_difference);
    along = spread > 0.0 ? normalize(along) : vec2(1.0, 0.0);
    vec2 across = vec2(-along.y, along.x);
    return mat2(along * (reach * sqrt(longest) + MARGIN), across * (reach * sqrt(determinant / longest) + MARGIN));
}

void main() {
    int index = int(splat);
    ivec2 texel = ivec2(4 * (index % splats_per_row), index / splats_per_row);
    vec4 mean_opacity = texelFetch(records, texel, 0);
    vec4 quat = texelFetch(records, texel + ivec2(1, 0), 0);
    vec3 scales = texelFetch(records, texel + ivec2(2, 0), 0).xyz;
    scales = min(abs(scales), vec3(LARGEST));
    vec3 color = texelFetch(records, texel + ivec2(3, 0), 0).rgb;

    vec3 local = rotation * mean_opacity.xyz + translation;
    float opacity = mean_opacity.w;
    float z = local.z;
    center = lens.xy * local.xy / z + lens.zw;

    // Rows of J W R S, so that the covariance is their Gram matrix plus the low-pass (Eqs 14, 15).
    vec2 slope = clamp(local.xy / z, slopes.xy, slopes.zw);
    mat3 spread = rotation * rotation_from(quat);
    mat3 rows = transpose(mat3(spread[0] * scales.x, spread[1] * scales.y, spread[2] * scales.z));
    vec3 first = (lens.x / z) * (rows[0] - slope.x * rows[2]);
    vec3 second = (lens.y / z) * (rows[1] - slope.y * rows[2]);
    float a = dot(first, first) + LOW_PASS;
    float b = dot(first, second);
    float c = dot(second, second) + LOW_PASS;
    // determinant / a from a sum of squares: accurate where a c - b^2 cancels, in range where it overflows.
    float root = inversesqrt(a);
    vec3 minors = cross(first * root, second);
    float remainder = dot(minors, minors) + LOW_PASS * (c / a + dot(first * root, first * root));
    shape = vec3(b / a, 1.0 / a, 1.0 / remainder);
    if (compensated) opacity *= length(minors) * inversesqrt(remainder);
    paint = vec4(depth_as_color ? vec3(z) : color, opacity);

    float reach = sqrt(max(0.0, 2.0 * log(255.0 * opacity)));
    vec2 extent = reach * sqrt(vec2(a, c)) + MARGIN;
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
    vec2 position;
    if (any(greaterThan(center - extent, size)) || any(lessThan(center + extent, vec2(0.0)))) {
        position = vec2(-size);                                  // beside the picture: no area
    } else if (max(extent.x, extent.y) > size.x + size.y) {
        position = (0.5 * corner + 0.5) * size;                  // dwarfs the picture: all of it
    } else {
        position = center + half_axes(a, b, c, a * remainder, reach) * corner;
    }
    gl_Position = vec4(2.0 * position / size - 1.0, 0.0, 1.0);
}
