#version 330 core
// The accumulated picture over the background, turned the way OpenGL stores images: bottom row first.

uniform sampler2D accumulated;   // premultiplied rgb - pivot, transmittance; top row first
uniform sampler2D rows;          // its means along rows
uniform int closing;             // pixels over which gaps in it are closed, see closing.py; 0: drawn as it is
uniform float gone, whole;       // mean alpha of what is left out, and of what is opaque
uniform ivec2 origin;            // lower left corner of the viewport
uniform vec3 background, lines, pivot;
uniform int period, line_width;  // of the lines over the background, in pixels along a row

out vec4 color;

// With gaps closed, of the same form.
vec4 closed(vec4 sum, ivec2 place) {
    int first = max(place.y - closing, 0), last = min(place.y + closing, textureSize(rows, 0).y - 1);
    vec4 mean = vec4(0.0);
    for (int y = first; y <= last; ++y) mean += texelFetch(rows, ivec2(place.x, y), 0);
    mean /= float(last - first + 1);
    float share = 1.0 - mean.a;
    if (share <= gone) return vec4(0.0, 0.0, 0.0, 1.0);
    float t = min((share - gone) / (whole - gone), 1.0);
    t = t * t * (3.0 - 2.0 * t);
    return vec4(t * (sum.rgb + sum.a * mean.rgb / share), 1.0 - t);
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy) - origin;
    ivec2 place = ivec2(pixel.x, textureSize(accumulated, 0).y - 1 - pixel.y);
    vec4 sum = texelFetch(accumulated, place, 0);
    if (closing > 0) sum = closed(sum, place);
    vec3 behind = (place.x + place.y) % period < line_width ? lines : background;
    color = vec4(sum.rgb + pivot + sum.a * (behind - pivot), 1.0);
}
