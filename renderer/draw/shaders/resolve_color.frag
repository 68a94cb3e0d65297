#version 330 core
// The accumulated picture over the background, turned the way OpenGL stores images: bottom row first.

uniform sampler2D accumulated;   // premultiplied rgb - pivot, transmittance; top row first
uniform ivec2 origin;            // lower left corner of the viewport
uniform vec3 background, pivot;

out vec4 color;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy) - origin;
    vec4 sum = texelFetch(accumulated, ivec2(pixel.x, textureSize(accumulated, 0).y - 1 - pixel.y), 0);
    color = vec4(sum.rgb + pivot + sum.a * (background - pivot), 1.0);
}
