"""A URDF without muscles, an arm with one hinge about y, and a muscle table for it."""

LINK = """<link name="{name}"><inertial><mass value="1"/><origin xyz="0 0 -0.1"/>
<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>"""
URDF = f"""<robot name="arm">{LINK.format(name="base")}{LINK.format(name="upper")}
<joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>
<axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="0" velocity="3"/></joint></robot>"""
HEAD = "name,frame,link,x [m],y [m],z [m],f_max [N]\n"
TABLE = HEAD + (
    "front,link,base,0.05,0,0,100\nfront,link,upper,0.05,0,-0.1,\n"
    "back,link,base,-0.05,0,0,100\nback,link,upper,-0.05,0,-0.1,\n"
)
