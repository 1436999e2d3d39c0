// Surfaces that one looks through: faint from the front, strong along their outline.

const kGlassVertex = `
#ifdef TINTED
attribute vec3 tint;
#else
uniform vec3 tint;
#endif
uniform float lift;
varying vec3 vTint;
varying vec3 vNormal;
varying vec3 vPosition;
void main() {
  mat4 m = modelViewMatrix;
#ifdef USE_INSTANCING
  m = m * instanceMatrix;
#endif
  vec4 p = m * vec4(position, 1.0);
  vTint = tint;
  // Bodies are scaled along their own axes only, where these normals stay what they are.
  vNormal = mat3(m) * normal;
  vPosition = p.xyz;
  p.xyz *= 1.0 - min(lift / length(p.xyz), 0.5);
  gl_Position = projectionMatrix * p;
}`;

const kGlassFragment = `
uniform float body, rim, light;
varying vec3 vTint;
varying vec3 vNormal;
varying vec3 vPosition;
void main() {
  float facing = abs(dot(normalize(vNormal), normalize(vPosition)));
  float edge = pow(1.0 - facing, 2.5);
  vec3 color = vTint * mix(1.0, 0.55 + 0.5 * facing, light);
  gl_FragColor = vec4(color, mix(body, rim, edge));
}`;

/**
 * @param body, rim  opacity seen from the front and along the outline
 * @param extra      of THREE.ShaderMaterial; color: of the whole, or none: an attribute `tint` has it; lift (m): nearer
 *                   to the camera, but at the same place of the picture: out of the noise of points that lie on it
 */
function glass(body, rim, { color, light = 1, lift = 0, ...extra }) {
  return new THREE.ShaderMaterial({
    vertexShader: kGlassVertex,
    fragmentShader: kGlassFragment,
    defines: color ? {} : { TINTED: "" },
    uniforms: {
      body: { value: body },
      rim: { value: rim },
      light: { value: light },
      lift: { value: lift },
      ...(color && { tint: { value: new THREE.Color(color) } }),
    },
    transparent: true,
    depthWrite: false,
    ...extra,
  });
}
