#version 330 core
// Premultiplied colour of one splat at one pixel (Eq 16 without the sum, which blending makes), told from
// `pivot`: sums near zero are those that a half float holds best.

const float ALPHA_MAX = 0.99;

uniform float faintest;          // alpha below it is not drawn
uniform vec3 pivot;

flat in vec2 center;
flat in vec3 shape;
flat in vec4 paint;
flat in vec2 solid;
in vec4 inside;
in vec2 inside_field;

out vec4 premultiplied;

void main() {
    vec2 offset = gl_FragCoord.xy - center;
    float sheared = offset.y - shape.x * offset.x;
    float distance = offset.x * offset.x * shape.y + sheared * sheared * shape.z;
    if (solid.x > 0.0) {
        float share = distance / solid.x;
        if (share > 1.0) discard;
        premultiplied = vec4(paint.rgb * (1.0 - solid.y * share * share) - pivot, 1.0);
        return;
    }
    float nearest = min(min(inside.x, inside.y), min(inside.z, inside.w));
    nearest = min(nearest, min(inside_field.x, inside_field.y));
    float alpha = min(ALPHA_MAX, paint.a * exp(-0.5 * distance)) * clamp(nearest + 0.5, 0.0, 1.0);
    if (alpha < faintest) discard;
    premultiplied = vec4((paint.rgb - pivot) * alpha, alpha);
}
