#version 330 core
// The accumulated picture over the background, turned the way OpenGL stores images: bottom row first.

uniform sampler2D accumulated;   // premultiplied rgb - pivot, transmittance; top row first
uniform ivec2 origin;            // lower left corner of the viewport
uniform vec3 background, lines, pivot;
uniform int period, line_width;  // of the lines over the background, in pixels along a row

out vec4 color;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy) - origin;
    ivec2 place = ivec2(pixel.x, textureSize(accumulated, 0).y - 1 - pixel.y);
    vec4 sum = texelFetch(accumulated, place, 0);
    vec3 behind = (place.x + place.y) % period < line_width ? lines : background;
    color = vec4(sum.rgb + pivot + sum.a * (behind - pivot), 1.0);
}
