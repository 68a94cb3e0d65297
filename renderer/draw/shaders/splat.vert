#version 330 core
// One quad a splat, along the eigenvectors of its image covariance, just wide enough for alpha >= 1/255.
// Positions are in pixels with y down: row 0 of the target is the top row of the picture.

const float LOW_PASS = 0.3;      // px^2
const float MARGIN = 0.02;       // px; covers the snapping of corners to the sub-pixel grid
const float LARGEST = 1e12;      // scene units; flat over any picture, and its square still a float

const float LEAST_SLOPE = 1e-20, FAR = 1e6;     // scene units a px; px
const float LARGEST_DISTANCE = 3e38;            // scene units

const int ELLIPSOID = 1, POINT = 2;
const float ELLIPSOID_REACH = 1.5;     // standard deviations
const float LEAST_OPACITY = 0.1;       // of ellipsoids
const float POINT_RADIUS = 1.25;       // px
const float RIM = 0.55;                // an ellipsoid is so much darker at its edge
const int DEPTH = 1, MOTION = 2;

const int ROW = 1024;            // splats in a row of records and offsets
const int HARMONICS_ROW = 256;

uniform sampler2D records;       // four texels a splat: mean opacity | quat wxyz | scales - | color slot
uniform sampler2D harmonics;     // `functions` texels a splat
uniform int functions;
uniform vec3 eye;                // the camera's centre
uniform sampler2DArray place_offsets, turn_offsets, size_offsets, paint_offsets;   // a layer a keyframe
uniform bvec4 moves;             // which of them there are
uniform ivec2 layers;            // the keyframes before and after
uniform float share;             // of the way between them
uniform mat3 rotation;           // camera_from_world
uniform vec3 translation;
uniform vec4 lens;               // fx fy cx cy
uniform vec4 slopes;             // least x/z, y/z and greatest x/z, y/z that the Jacobian follows
uniform float widest;            // standard deviations that a quad reaches at most
uniform float faintest;          // alpha at which it ends
uniform vec2 size;               // width height
uniform int painted;             // 0: in the splat's colour
uniform int body;                // 0: soft
uniform bool compensated;        // opacity makes up for the low-pass
uniform bool bounded;            // by four planes, beyond which nothing is drawn
uniform vec4 sides[4];           // of the planes: normal inwards, distance of the origin
uniform vec4 field[96];          // of more of them: those two count that are nearest to a splat
uniform int corners;             // how many there are

in uint splat;

flat out vec2 center;            // px
flat out vec3 shape;             // of the covariance (a b; b c): b / a, 1 / a, a / determinant
flat out vec4 paint;             // rgb, opacity
flat out vec2 solid;             // squared standard deviations to the edge of a body, 0: none; darker at it
out vec4 inside;   // px to where the splat crosses each plane; see crossings.py
out vec2 inside_field;

// What time adds to a texel of the splat in `slot`.
vec4 offset(sampler2DArray offsets, int slot) {
    ivec2 at = ivec2(slot % ROW, slot / ROW);
    vec4 before = texelFetch(offsets, ivec3(at, layers.x), 0);
    return share > 0.0 ? mix(before, texelFetch(offsets, ivec3(at, layers.y), 0), share) : before;
}

// What the direction from the eye adds to the colour: the functions of harmonics.py.
vec3 seen_from(vec3 direction, ivec2 at) {
    float range = length(direction);
    vec3 d = range > 0.0 ? direction / range : vec3(0.0);
    float x = d.x, y = d.y, z = d.z, xx = x * x, yy = y * y, zz = z * z;
    float values[15] = float[15](
        -0.4886025119 * y, 0.4886025119 * z, -0.4886025119 * x,
        1.0925484306 * x * y, -1.0925484306 * y * z, 0.3153915653 * (2.0 * zz - xx - yy),
        -1.0925484306 * x * z, 0.5462742153 * (xx - yy),
        -0.5900435899 * y * (3.0 * xx - yy), 2.8906114426 * x * y * z,
        -0.4570457995 * y * (4.0 * zz - xx - yy), 0.3731763326 * z * (2.0 * zz - 3.0 * (xx + yy)),
        -0.4570457995 * x * (4.0 * zz - xx - yy), 1.4453057213 * z * (xx - yy),
        -0.5900435899 * x * (xx - 3.0 * yy));
    vec3 sum = vec3(0.0);
    for (int index = 0; index < functions; ++index)
        sum += values[index] * texelFetch(harmonics, at + ivec2(index, 0), 0).rgb;
    return sum;
}

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

// Distance in px, at `offset` from the centre, to the line where a splat crosses a plane: of the likeliest point
// behind a pixel, which is linear in the offset. `axes` are the splat's half axes along the plane's normal.
float to_side(float distance, vec3 axes, vec3 first, vec3 second, vec2 offset) {
    vec2 along = vec2(dot(first, axes), dot(second, axes));
    float sheared = along.y - shape.x * along.x;
    vec2 slope = vec2(along.x * shape.y - shape.x * sheared * shape.z, sheared * shape.z);
    return clamp((distance + dot(slope, offset)) / max(length(slope), LEAST_SLOPE), -FAR, FAR);
}

// The two sides of the field that are nearest to a point.
ivec2 nearest_sides(vec3 point) {
    vec2 least = vec2(LARGEST_DISTANCE);
    ivec2 nearest = ivec2(0);
    for (int side = 0; side < corners; ++side) {
        float distance = dot(field[side].xyz, point) + field[side].w;
        if (distance < least.x) {
            least = vec2(distance, least.x);
            nearest = ivec2(side, nearest.x);
        } else if (distance < least.y) {
            least.y = distance;
            nearest.y = side;
        }
    }
    return nearest;
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
    ivec2 texel = ivec2(4 * (index % ROW), index / ROW);
    vec4 mean_opacity = texelFetch(records, texel, 0);
    vec4 quat = texelFetch(records, texel + ivec2(1, 0), 0);
    vec3 scales = texelFetch(records, texel + ivec2(2, 0), 0).xyz;
    vec4 color_slot = texelFetch(records, texel + ivec2(3, 0), 0);
    vec3 color = color_slot.rgb;
    int slot = int(color_slot.a) - 1;
    vec4 moved = vec4(0.0);
    if (slot >= 0) {
        if (moves.x) moved = offset(place_offsets, slot);
        mean_opacity += moved;
        if (moves.y) quat += offset(turn_offsets, slot);
        if (moves.z) scales += offset(size_offsets, slot).xyz;
        if (moves.w) color += offset(paint_offsets, slot).rgb;
    }
    scales = min(abs(scales), vec3(LARGEST));
    if (functions > 0) {
        ivec2 at = ivec2(functions * (index % HARMONICS_ROW), index / HARMONICS_ROW);
        color += seen_from(mean_opacity.xyz - eye, at);
    }

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
    if (painted == DEPTH) color = vec3(z);
    if (painted == MOTION) color = vec3(length(moved.xyz));
    paint = vec4(color, opacity);

    float reach = min(widest, sqrt(max(0.0, 2.0 * log(opacity / faintest))));
    solid = vec2(0.0);
    bool hidden = false;
    if (body != 0) {
        hidden = body == ELLIPSOID && mean_opacity.w < LEAST_OPACITY;
        reach = body == POINT ? POINT_RADIUS : ELLIPSOID_REACH;
        solid = vec2(reach * reach, body == POINT || painted != 0 ? 0.0 : RIM);
        if (body == POINT) {
            a = c = remainder = 1.0;
            b = 0.0;
            shape = vec3(0.0, 1.0, 1.0);
        }
    }
    vec2 extent = reach * sqrt(vec2(a, c)) + MARGIN;
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
    vec2 position;
    if (hidden || any(greaterThan(center - extent, size)) || any(lessThan(center + extent, vec2(0.0)))) {
        position = vec2(-size);                                  // beside the picture: no area
    } else if (max(extent.x, extent.y) > size.x + size.y) {
        position = (0.5 * corner + 0.5) * size;                  // dwarfs the picture: all of it
    } else {
        position = center + half_axes(a, b, c, a * remainder, reach) * corner;
    }
    inside = vec4(FAR);
    inside_field = vec2(FAR);
    if (bounded) {
        mat3 axes = rotation_from(quat);
        ivec2 nearest = nearest_sides(mean_opacity.xyz);
        for (int side = 0; side < (corners > 0 ? 6 : 4); ++side) {
            vec4 plane = side < 4 ? sides[side] : field[nearest[side - 4]];
            float distance = dot(plane.xyz, mean_opacity.xyz) + plane.w;
            float apart = to_side(distance, (plane.xyz * axes) * scales, first, second, position - center);
            if (side < 4) inside[side] = apart; else inside_field[side - 4] = apart;
        }
    }
    gl_Position = vec4(2.0 * position / size - 1.0, 0.0, 1.0);
}
