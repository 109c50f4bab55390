"""Five minutes with Pierce: two tori overlap, and every contact is an entry in NumPy arrays.

python first_contact.py [folder for the picture]
"""

import matplotlib.pyplot as plt
import numpy as np
import pierce
from _plot import BLUE, ORANGE, draw_contacts, draw_mesh, placed, save, set_box, torus

# A mesh is a pair of arrays, or what trimesh and meshio have read. Any number of bodies share it.
vertices, triangles = torus()
world = pierce.World()
mesh = world.add_mesh((vertices, triangles), "torus")
lying = world.add_fixed_body(mesh)
pose = [1.0, 0.0, 1.6, np.sqrt(0.5), 0, 0, np.sqrt(0.5)]  # position, quaternion x, y, z, w
standing = world.add_rigid_body(mesh, pose)

# A step finds all contacts of all bodies where they are now.
contacts = world.detect()
depth = contacts.depth
deepest = int(depth.argmax())
print(
    f"{len(contacts)} contacts; the deepest, {depth[deepest]:.3f} m, "
    f"has the normal {np.round(contacts.normal[deepest], 3)}"
)

# How far does the standing torus have to move until the two are apart?
parting = world.parting(lying, standing)
print(f"they are apart after {parting.depth:.3f} m along {np.round(parting.direction, 3)}")

# Why does a vertex have a contact, or none?
top = int(vertices[:, 1].argmin())
print(f"vertex {top}: {world.explain(standing, lying, top).text}")

figure = plt.figure(figsize=(11, 4.8))
whole, near = (figure.add_subplot(1, 2, place, projection="3d") for place in (1, 2))
moved, points = placed(vertices, pose), contacts.point_a
middle = points.mean(0)
for axes, alpha, radius in ((whole, 1.0, np.inf), (near, 0.2, 0.5)):
    draw_mesh(axes, vertices, triangles, BLUE, alpha, middle, radius)
    draw_mesh(axes, moved, triangles, ORANGE, alpha, middle, radius)
    axes.view_init(18, -60)
set_box(whole, vertices, moved)
whole.set_title("two tori, one mesh")
draw_contacts(near, points, depth, contacts.normal, length=0.3)
set_box(near, np.add(middle, [[-0.45, -0.45, -0.3], [0.45, 0.45, 0.4]]))
near.set_title("contacts: points of the blue one,\nnormals to the orange one")
save(figure, "first_contact")
