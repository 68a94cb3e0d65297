#version 330 core
// Expected depth as a grey ramp, near white and far black, over the background by coverage.

uniform sampler2D accumulated;   // depth * alpha, ., ., alpha; top row first
uniform ivec2 origin;            // lower left corner of the viewport
uniform vec3 background;
uniform vec2 depth_range;        // white, black

out vec4 color;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy) - origin;
    vec4 sum = texelFetch(accumulated, ivec2(pixel.x, textureSize(accumulated, 0).y - 1 - pixel.y), 0);
    float depth = sum.a > 0.0 ? sum.r / sum.a : depth_range.y;
    float grey = clamp((depth_range.y - depth) / (depth_range.y - depth_range.x), 0.0, 1.0);
    color = vec4(mix(background, vec3(grey), sum.a), 1.0);
}
