#version 330 core
// Of each pixel, the mean over those of its row that are at most `closing` away; see closing.py.

uniform sampler2D accumulated;
uniform int closing;

out vec4 mean;

void main() {
    ivec2 place = ivec2(gl_FragCoord.xy);
    int first = max(place.x - closing, 0), last = min(place.x + closing, textureSize(accumulated, 0).x - 1);
    vec4 sum = vec4(0.0);
    for (int x = first; x <= last; ++x) sum += texelFetch(accumulated, ivec2(x, place.y), 0);
    mean = sum / float(last - first + 1);
}
